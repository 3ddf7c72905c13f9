// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/range_readings.h"

#include <cmath>

#include "estimator/geometry/so3.h"
#include "estimator/window/range_config.h"
#include "platform/base/angle.h"

namespace facet {

Status RangeReadings::push(const RangeSample& sample) {
    if (!sample.p_B.allFinite()) {
        return Status::kInvalidArgument;
    }
    if (!samples_.empty() && sample.stamp <= samples_.back().stamp) {
        return Status::kOutOfOrder;
    }
    samples_.push(sample);
    return Status::kOk;
}

std::optional<Eigen::Vector3d> RangeReadings::ground_B(Timestamp stamp, const NavState& state,
                                                       const Eigen::Vector3d& w_B) const {
    static const double kLeastCosine = std::cos(RangeConfig::kMaxTilt_deg * kRadPerDeg);
    std::size_t count = samples_.size();
    while (count > 0 && samples_[count - 1].stamp > stamp) {
        --count;
    }
    if (count == 0) {
        return std::nullopt;
    }
    const RangeSample& sample = samples_[count - 1];
    const double dt_s = (stamp - sample.stamp).seconds();
    const Eigen::Vector3d p_B = so3_exp(-dt_s * w_B) * sample.p_B - state.q_W_B.conjugate() * (dt_s * state.v_W_B);
    const bool is_below = -(state.q_W_B * p_B).z() > kLeastCosine * p_B.norm();
    if (dt_s > kMaxAge_s || !is_below) {
        return std::nullopt;
    }
    return p_B;
}

}  // namespace facet
