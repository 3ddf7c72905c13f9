// SPDX-License-Identifier: BSD-2-Clause
// The time of MAVLink's signatures across restarts of program and computer.
#pragma once

#include <cstdint>
#include <string>

#include "platform/port/clock.h"

namespace facet {

/// A flight controller refuses a signature that is not newer than the last one it has seen. A computer without a
/// real-time clock begins at a time long past after a reboot, and would be refused until its clock is set. So the
/// newest time is kept in the file `signing_time` of a folder, every kPeriod, and the next program begins at that far
/// behind it: later than whatever was signed since. Thread-bound. Heap.
class SigningTime {
public:
    static constexpr Duration kPeriod = Duration::from_seconds(10.0);

    /// Reads what was kept. @param folder  empty: nothing is kept
    SigningTime(const std::string& folder, const Clock& clock);

    /// In units of 10 us since 2015, as MAVLink has it; zero if nothing was kept.
    std::uint64_t first() const { return first_; }
    /// Keeps the time if the last one was kept a period ago. @param time  zero: there is none
    /// @return why it cannot be kept, in words; empty if it is, and when it is tried no more
    std::string keep(std::uint64_t time);

private:
    std::string path_;  ///< empty: not kept
    const Clock& clock_;
    Timestamp next_;
    std::uint64_t first_ = 0;
};

}  // namespace facet
