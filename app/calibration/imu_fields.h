// SPDX-License-Identifier: BSD-2-Clause
// Readers of what calibration files say of an IMU.
#pragma once

#include <string>

#include "app/calibration/imu_model.h"
#include "app/support/yaml_file.h"
#include "estimator/values/imu_noise.h"

namespace facet {

/// Densities and walks in continuous time, SI, and the rate under the given key. Throws InputError if a field is
/// missing or outside its range in kImuNoiseFields.
ImuNoise read_imu_noise(const YamlNode& imu, const std::string& rate_key);

/// One figure, within the range of the parameter that it becomes. Throws as above.
void read_noise(const YamlNode& node, double ImuNoise::*member, ImuNoise& noise);

/// Kalibr's accelerometers.M, gyroscopes.M, A and C_gyro_i, or OpenVINS's Ta, R_IMUtoACC, Tw, R_IMUtoGYRO and Tg; what
/// is not there is ideal. Throws InputError if one is not a matrix, or if the sensors would be off by more than a half.
ImuModel read_imu_model(const YamlNode& imu);

/// As above of matrices that have been read; `blame` is what errors name.
ImuModel checked_imu_model(const Eigen::Matrix3d& M_a, const Eigen::Matrix3d& M_w, const Eigen::Matrix3d& M_g,
                           const YamlNode& blame);

}  // namespace facet
