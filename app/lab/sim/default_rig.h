// SPDX-License-Identifier: BSD-2-Clause
// The simulated vehicle's sensors: EuRoC's VI sensor (two MT9V034 cameras, one ADIS16448), with its lenses or others.
#pragma once

#include <cstdint>

#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/imu_noise.h"

namespace facet::sim {

/// Calibration of the EuRoC sequences: Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 2016.
StereoRig euroc_rig();
/// The same sensor behind fisheye lenses of 160 degrees across: equidistant, with coefficients as of a real lens. The
/// image's corners lie beyond the angle that the camera model is used for, 84 degrees, and stay black.
StereoRig fisheye_rig();
/// The IMU's noise.
ImuNoise euroc_imu_noise();

/// The sensor's cameras with these lenses.
enum class LensKind : std::uint8_t { kPinhole, kFisheye };
StereoRig rig_with(LensKind lens);

/// The calibration's own extrinsic matrices, row by row, for writing sensor.yaml without loss.
Eigen::Matrix4d euroc_T_B_C(int camera);

}  // namespace facet::sim
