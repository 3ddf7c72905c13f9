// SPDX-License-Identifier: BSD-2-Clause
// Keeps the stamps of delivered samples increasing.
#pragma once

#include <cstdint>
#include <optional>

#include "platform/port/clock.h"

namespace facet {

/// A sample may be delivered if its stamp is after that of the sample delivered last, however long ago that was:
/// devices are reopened. The monotonic clock is never set back; any other may be, and then the order restarts: at
/// the kSetBack-th sample in a row that is refused although those refused increase among themselves. Thread-bound. No
/// heap.
class IncreasingStamps {
public:
    /// A clock that stands still, or samples that change places, never give so many.
    static constexpr int kSetBack = 5;

    /// @param clock  that of the stamps
    explicit IncreasingStamps(ClockDomain clock = ClockDomain::kMonotonic)
        : is_set_back_(clock != ClockDomain::kMonotonic) {}

    /// Whether a sample may be delivered; if not, it is counted. @param refused  is raised by one then
    bool allows(Timestamp stamp, std::uint64_t& refused) {
        const bool increases = !last_ || stamp > *last_;
        behind_ = increases ? 0 : (behind_ > 0 && stamp > last_refused_ ? behind_ + 1 : 1);
        last_refused_ = stamp;
        if (increases || (is_set_back_ && behind_ >= kSetBack)) {
            return true;
        }
        ++refused;
        return false;
    }
    /// A sample that allows() accepted was delivered.
    void delivered(Timestamp stamp) {
        last_ = stamp;
        behind_ = 0;
    }
    /// Both, for samples that are delivered as soon as they are allowed.
    bool pass(Timestamp stamp, std::uint64_t& refused) {
        if (!allows(stamp, refused)) {
            return false;
        }
        delivered(stamp);
        return true;
    }

private:
    bool is_set_back_;
    std::optional<Timestamp> last_;
    int behind_ = 0;  ///< refused in a row, increasing among themselves
    Timestamp last_refused_;
};

}  // namespace facet
