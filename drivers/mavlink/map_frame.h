// SPDX-License-Identifier: BSD-2-Clause
// Poses in the map of places instead of the odometry's world.
#pragma once

#include <cstdint>

#include "platform/port/odometry_sink.h"

namespace facet {

/// Carries poses over to the map, whose vertical is that of W. Until the pose in the map is known for the first time, W
/// counts as the map; while it is unknown again, the last correction. A correction that moves the vehicle by more than
/// a filter takes for noise is a jump, and is counted. Thread-bound. No heap.
class MapFrame {
public:
    /// A flight controller's filter weighs poses by centimetres; what the map is corrected by at a known place is
    /// millimetres.
    static constexpr double kJump_m = 0.05;
    static constexpr double kJump_rad = 0.02;

    /// The pose in the map, its reset counter raised by the jumps so far.
    Odometry carried(const Odometry& odometry);

private:
    double yaw_ = 0.0;
    Eigen::Vector3d p_ = Eigen::Vector3d::Zero();
    std::uint8_t jumps_ = 0;
};

}  // namespace facet
