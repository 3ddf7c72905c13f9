// SPDX-License-Identifier: BSD-2-Clause
// The newest readings of a range finder, and what one of them says at a keyframe.
#pragma once

#include <optional>

#include "estimator/values/nav_state.h"
#include "platform/base/range_sample.h"
#include "platform/base/ring_buffer.h"
#include "platform/base/status.h"

namespace facet {

/// Keeps the newest readings. Thread-bound. No heap.
class RangeReadings {
public:
    /// @return kInvalidArgument if it is not finite, kOutOfOrder if its stamp is not after the newest's (dropped)
    Status push(const RangeSample& sample);
    void clear() { samples_.clear(); }

    /// The ground of the newest reading before a stamp, as seen by the body then: carried on over the time between by
    /// rate and velocity,
    ///   m' = Exp(-w dt) m - R' v dt.
    /// None if that reading is older than kMaxAge_s, or if its beam was farther from the vertical than
    /// RangeConfig::kMaxTilt_deg.
    /// @param w_B  rate, bias subtracted (rad/s)
    std::optional<Eigen::Vector3d> ground_B(Timestamp stamp, const NavState& state, const Eigen::Vector3d& w_B) const;

    /// Whether there were readings, but for kSilent_s none any more.
    bool are_missing(Timestamp now) const {
        return !samples_.empty() && (now - samples_.back().stamp).seconds() > kSilent_s;
    }

    static constexpr double kMaxAge_s = 0.1;  ///< range finders give ten readings a second at least
    static constexpr double kSilent_s = 1.0;

private:
    static constexpr std::size_t kCapacity = 64;  ///< 0.3 s at 200 Hz: a frame that comes late finds its own
    RingBuffer<RangeSample, kCapacity> samples_;
};

}  // namespace facet
