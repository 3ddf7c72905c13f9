// SPDX-License-Identifier: BSD-2-Clause
// Keeps a flight's log through a power failure, and room for it on the disk.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "platform/port/clock.h"

namespace facet {

/// What a log keeper looks after.
struct LogKeeping {
    std::string folder;             ///< of this flight
    std::string parent;             ///< of all flights; empty: there are no others
    std::uint64_t limit_bytes = 0;  ///< of all flights; zero: none is removed
};

/// Once a second it brings to the disk what others have written into the folder (names too), and at the start and every
/// half minute it removes the oldest flights (remove_old_flights). On a thread of its own, because a disk may take
/// seconds for either. Thread-bound but for failure().
class LogKeeper {
public:
    static constexpr Duration kSyncPeriod = Duration::from_seconds(1.0);
    static constexpr Duration kRemovePeriod = Duration::from_seconds(30.0);

    /// @param clock  borrowed. Throws InputError if the folder is not there.
    LogKeeper(Clock& clock, LogKeeping keeping);
    ~LogKeeper();
    LogKeeper(const LogKeeper&) = delete;
    LogKeeper& operator=(const LogKeeper&) = delete;

    /// Body of its thread, until it is `stopping`.
    void keep(const std::atomic<bool>& stopping);
    /// Brings to the disk what is in the folder now. Blocks as long as the disk does.
    void sync();

    /// Once nothing else uses the object: why the disk does not hold what was written; empty if it does.
    const std::string& failure() const { return failure_; }

private:
    Clock& clock_;
    LogKeeping keeping_;
    int folder_;  ///< descriptor
    std::string failure_;
};

}  // namespace facet
