// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/obstacle_sweep.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace facet {

static_assert(ObstacleRanges::kSectors == kSweepSectors);

bool ObstacleSweep::sweep(const Estimate& estimate, ObstacleRanges& ranges) {
    constexpr double kSlack = 0.01;  // of a period: stamps jitter
    if (any_ && (estimate.stamp - last_).seconds() * options_.rate_hz < 1.0 - kSlack) {
        return false;
    }
    any_ = true;
    last_ = estimate.stamp;
    const Eigen::Vector3d ahead_W = estimate.state.q_W_B * Eigen::Vector3d::UnitX();
    constexpr double kWidth = 2.0 * std::numbers::pi / kSweepSectors;
    const SweepRequest request{.p_W = estimate.state.p_W_B,
                               .start_rad = std::atan2(ahead_W.y(), ahead_W.x()) - 0.5 * kWidth,
                               .below_m = options_.below_m,
                               .above_m = options_.above_m,
                               .max_range_m = options_.max_range_m};
    std::array<double, kSweepSectors> counterclockwise{};
    query_->sweep(request, counterclockwise);
    ranges.stamp = estimate.stamp;
    ranges.max_range_m = options_.max_range_m;
    for (std::size_t k = 0; k < ranges.range_m.size(); ++k) {
        const double range_m = counterclockwise[(kSweepSectors - k) % kSweepSectors];
        ranges.range_m[k] =
            range_m < options_.max_range_m ? static_cast<float>(range_m) : std::numeric_limits<float>::quiet_NaN();
    }
    return true;
}

}  // namespace facet
