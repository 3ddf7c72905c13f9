// SPDX-License-Identifier: BSD-2-Clause
// Checks of cameras against IMU by how both turn: axes, units, clocks.
#pragma once

#include <span>
#include <vector>

#include "app/lab/check/camera_turn.h"
#include "app/lab/check/verdict.h"
#include "platform/base/samples.h"

namespace facet {

/// Three verdicts.
/// "imu axes": rates of gyroscope and camera, each less its mean, are fitted by every signed permutation of the axes
/// (24 rotations, 24 reflections) times the calibration's rotation; wrong if another one than the identity explains
/// clearly more, suspicious if the rotation found is more than 3 degrees from the given one. The inverse of the given
/// rotation is tried too.
/// "gyroscope units": the ratio of the rates; within 10 % ok, within 30 % suspicious; names degrees.
/// "time offset": the shift of the images' stamps, within 0.15 s, at which the rates agree best, whatever the rotation;
/// to 5 ms ok, to 20 ms suspicious (the estimator finds such offsets), beyond wrong.
/// All cannot tell if the vehicle turns less than 0.1 rad/s rms, or images and gyroscope do not agree at any shift.
/// @param R_B_C  rotation of the left camera on the body, given
std::vector<CheckVerdict> check_turns(std::span<const CameraTurn> turns, std::span<const ImuSample> samples,
                                      const Eigen::Matrix3d& R_B_C);

}  // namespace facet
