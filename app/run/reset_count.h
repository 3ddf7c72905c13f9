// SPDX-License-Identifier: BSD-2-Clause
// The reset counter of poses across restarts of the program.
#pragma once

#include <cstdint>
#include <string>

namespace facet {

/// A flight controller takes a jump of the pose for one only if the counter differs from that of the pose before. A
/// program that restarts (watchdog, crash) begins at the origin, so its first counter must differ from the last one
/// sent, which is kept in the file `reset_counter` of a folder. Thread-bound. Heap.
class ResetCount {
public:
    /// Reads what was kept. @param folder  empty: nothing is kept, and the count begins at zero
    explicit ResetCount(const std::string& folder);

    /// For the first pose: one more than the last one kept, modulo 256; zero if there is none.
    std::uint8_t first() const { return first_; }
    bool is_restart() const { return is_restart_; }
    /// Keeps the counter that is sent now, unless it is kept already.
    /// @return why it cannot be kept, in words; empty if it is, and when it is tried no more
    std::string keep(std::uint8_t counter);

private:
    std::string path_;  ///< empty: not kept
    bool is_restart_ = false;
    bool is_kept_ = false;
    std::uint8_t first_ = 0;
    std::uint8_t kept_ = 0;
};

}  // namespace facet
