// SPDX-License-Identifier: BSD-2-Clause
// The simulated vehicle's sensors: EuRoC's VI sensor (two MT9V034 cameras, one ADIS16448).
#pragma once

#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/imu_noise.h"

namespace facet::sim {

/// Calibration of the EuRoC sequences: Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 2016.
StereoRig euroc_rig();
/// Its inertial noise.
ImuNoise euroc_imu_noise();

/// The calibration's own extrinsic matrices, row by row, for writing sensor.yaml without loss.
Eigen::Matrix4d euroc_T_B_C(int camera);

}  // namespace facet::sim
