// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/obstacle_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace facet {

static_assert(ObstacleRanges::kSectors == kSweepSectors);

namespace {

constexpr float kFarAway = std::numeric_limits<float>::infinity();
constexpr double kFaceMargin_m = 0.15;  // cells are coarser than faces

/// Range as ObstacleRanges has it: a distance, infinity if free, NaN if unknown.
float range_of(double face_m, const GridSector& sector, double max_range_m) {
    const bool is_in_free = face_m + kFaceMargin_m < static_cast<double>(sector.free_m);
    const float face = face_m < max_range_m && !is_in_free ? static_cast<float>(face_m) : kFarAway;
    const float nearest = std::min(face, sector.obstacle_m);
    if (nearest < kFarAway || sector.state.space == Space::kFree) {
        return nearest;
    }
    return std::numeric_limits<float>::quiet_NaN();
}

}  // namespace

bool ObstacleSweep::sweep(const Estimate& estimate, const OccupancyGrid* grid, ObstacleRanges& ranges) {
    constexpr double kSlack = 0.01;  // of a period: stamps jitter
    if (any_ && (estimate.stamp - last_).seconds() * options_.rate_hz < 1.0 - kSlack) {
        return false;
    }
    any_ = true;
    last_ = estimate.stamp;
    const Se3 T_W_body = Se3{estimate.state.q_W_B, estimate.state.p_W_B} * T_imu_body_;
    const Eigen::Vector3d ahead_W = T_W_body.q * Eigen::Vector3d::UnitX();
    constexpr double kWidth = 2.0 * std::numbers::pi / kSweepSectors;
    const SweepRequest request{.p_W = T_W_body.p,
                               .start_rad = std::atan2(ahead_W.y(), ahead_W.x()) - 0.5 * kWidth,
                               .below_m = options_.below_m,
                               .above_m = options_.above_m,
                               .max_range_m = options_.max_range_m};
    std::array<double, kSweepSectors> counterclockwise{};
    query_->sweep(request, counterclockwise);
    std::array<GridSector, kSweepSectors> sectors{};
    if (grid != nullptr) {
        grid->sweep({.p_W = request.p_W,
                     .start_rad = request.start_rad,
                     .below_m = request.below_m,
                     .above_m = request.above_m,
                     .max_range_m = request.max_range_m},
                    sectors);
    }
    ranges.stamp = estimate.stamp;
    ranges.max_range_m = options_.max_range_m;
    for (std::size_t k = 0; k < ranges.range_m.size(); ++k) {
        const std::size_t from = (kSweepSectors - k) % kSweepSectors;
        ranges.range_m[k] = range_of(counterclockwise[from], sectors[from], options_.max_range_m);
    }
    return true;
}

}  // namespace facet
