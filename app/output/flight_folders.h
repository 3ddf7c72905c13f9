// SPDX-License-Identifier: BSD-2-Clause
// A folder for each flight, and room for the newest of them.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace facet {

/// Makes the folder of a flight, "flight_00001" and so on: its number is one more than the greatest in `parent`, so
/// that the order of flights does not depend on the wall clock, which a vehicle may not have. Nothing is ever
/// overwritten: of two programs that begin at once, each gets a folder of its own. Reentrant; heap.
/// @param parent  made if it is not there
/// @return the path of the new, empty folder. Throws InputError if it cannot be made.
std::string begin_flight(const std::string& parent);

/// How much of the past is kept.
struct FlightLimit {
    std::uint64_t bytes = 0;  ///< that all flights may take up on the disk
    std::string current;      ///< the path of the flight that is being written
};

/// Removes the oldest flights of `parent` until the rest fits. Never removed are the current flight, the one before it
/// (whose end may be what the current one is about), and flights that another program is writing; other files in
/// `parent` are neither counted nor touched. What cannot be removed is left. Takes as long as the disk does. Reentrant;
/// heap.
/// @param stopping  once true, it returns after the file at hand; the next call goes on
/// @return the number of flights removed
int remove_old_flights(const std::string& parent, const FlightLimit& limit, const std::atomic<bool>& stopping);

}  // namespace facet
