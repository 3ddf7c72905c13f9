// SPDX-License-Identifier: BSD-2-Clause
// The calibration of a RealSense camera, as its own tool lists it.
#pragma once

#include <string>

#include "app/calibration/calibration.h"

namespace facet {

/// Whether a file is what rs-enumerate-devices prints, in UTF-8 or, as PowerShell redirects it, in UTF-16. False too if
/// it cannot be read.
bool is_realsense_listing(const std::string& path);

/// The listing of `rs-enumerate-devices -c`: the lenses of "Infrared 1" and "Infrared 2", else "Fisheye 1" and
/// "Fisheye 2", else "Color", at the resolution of the log's images, and their places against "Gyro" (else "Accel").
/// An extrinsic from A to B maps p_B = R p_A + t, in metres; frames are the cameras' optical ones, in whose directions
/// librealsense gives the readings of the IMU, too. What it calls inverse Brown-Conrady maps from the distorted point
/// to the undistorted one, and modified Brown-Conrady is OpenCV's only without tangential coefficients: both are
/// refused where that matters. Motion intrinsics are not used, since librealsense applies them.
/// @param images  of the log; zero: there must be one resolution only
/// Throws InputError naming file, line and what is missing, or the resolutions that there are.
void read_realsense(const std::string& path, const ImageExtent& images, Calibration& calibration);

}  // namespace facet
