// SPDX-License-Identifier: BSD-2-Clause
// What the parameters of a calibration are called in files and messages.
#pragma once

#include <array>

#include "estimator/window/rig_calibration.h"

namespace facet {

/// In the order and units of RigCalibration's tangent, the IMU's axes aside: time offset (s), rotation (rad) and place
/// (m) of both cameras on the body, the left lens, rotation and place of the right camera against the left one, the
/// right lens; of a lens focal lengths (relative), principal point (px) and coefficients of the distortion.
inline constexpr std::array<const char*, kImuScale> kCorrectionNames{
    "time_offset", "mount_theta_x", "mount_theta_y", "mount_theta_z", "mount_p_x",     "mount_p_y",
    "mount_p_z",   "left_fx",       "left_fy",       "left_cx",       "left_cy",       "left_d1",
    "left_d2",     "left_d3",       "left_d4",       "right_theta_x", "right_theta_y", "right_theta_z",
    "right_p_x",   "right_p_y",     "right_p_z",     "right_fx",      "right_fy",      "right_cx",
    "right_cy",    "right_d1",      "right_d2",      "right_d3",      "right_d4"};

}  // namespace facet
