// SPDX-License-Identifier: BSD-2-Clause
// Readers of the parts EuRoC and Kalibr calibration files share.
#pragma once

#include <optional>
#include <string>

#include "app/calibration/calibration.h"
#include "app/support/yaml_file.h"
#include "estimator/values/imu_noise.h"

namespace facet {

/// Rigid transform of a 4x4 matrix field. The rotation may be off orthonormality by 1e-3 (rounded files) and is then
/// projected onto SO(3). Throws InputError if it is farther off, reflects, or if the last row is not 0 0 0 1.
Se3 read_transform(const YamlNode& field);

/// Pinhole camera with resolution, intrinsics [fu fv cu cv], distortion_model, and coefficients under the given key.
/// Throws InputError if a field is missing or the model is implausible.
CameraModel read_camera(const YamlNode& camera, const std::string& coefficients_key);

/// Densities and walks in continuous time, SI, and the rate under the given key. Throws InputError if a field is
/// missing or outside its range in kImuNoiseFields.
ImuNoise read_imu_noise(const YamlNode& imu, const std::string& rate_key);

/// Throws InputError if the baseline is not between 1 mm and 10 m.
void check_baseline(const StereoRig& rig, const YamlNode& right_extrinsics);

/// From the keys that `facet calibrate` writes beside a camera's values: intrinsics_sigma [fu fv cu cv] (px),
/// distortion_sigma [4] (-), rotation_sigma_deg [3]. Empty unless both cameras have all three. Throws InputError if one
/// is no list of that many finite numbers.
std::optional<StatedSigmas> read_stated_sigmas(const YamlNode& left, const YamlNode& right);

}  // namespace facet
