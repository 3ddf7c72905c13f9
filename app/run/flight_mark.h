// SPDX-License-Identifier: BSD-2-Clause
// Whether the program begins in the middle of a flight.
#pragma once

#include <string>

namespace facet {

/// A file in a folder that lasts as long as the service does, over its restarts but not over a stop or a boot
/// (RuntimeDirectory with RuntimeDirectoryPreserve=restart of systemd). It is there from when a run works to its
/// orderly end: a run that finds it follows one that was killed, by the watchdog or a crash, and may be in the air,
/// where a sensor's self-test takes a second that the vehicle does not have and judges masses that the flight moves.
/// Thread-bound. Heap.
class FlightMark {
public:
    /// @param folder  empty, or one that cannot be written: there is no mark
    explicit FlightMark(const std::string& folder);

    /// The run before this one was broken off.
    bool is_continued() const { return is_continued_; }
    /// All sensors have started. A run that does not come so far leaves the mark as it was.
    void set() const;
    /// The run has ended in order.
    void clear() const;

private:
    std::string path_;  ///< empty: there is none
    bool is_continued_ = false;
};

}  // namespace facet
