// SPDX-License-Identifier: BSD-2-Clause
// What sensors deliver: inertial samples and stereo frames, SI units, one clock.
#pragma once

#include <Eigen/Core>

#include "platform/base/image_view.h"
#include "platform/base/timestamp.h"

namespace facet {

/// One inertial sample in the body frame B (= IMU frame).
struct ImuSample {
    Timestamp stamp;
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  ///< angular rate of B relative to W, in B (rad/s)
    Eigen::Vector3d a_B = Eigen::Vector3d::Zero();  ///< specific force, in B (m/s^2): reads +g upwards at rest
};

/// One synchronised stereo pair; stamp at exposure midpoint. The right view may be empty (a dropped right frame).
struct StereoFrame {
    Timestamp stamp;
    ImageView left;
    ImageView right;
    bool is_by_stamps = false;  ///< stamped by the cameras' own clocks because the trigger's edges fail
};

}  // namespace facet
