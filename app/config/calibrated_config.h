// SPDX-License-Identifier: BSD-2-Clause
// Parameters that come from the calibration unless they are given.
#pragma once

#include <algorithm>

#include "app/calibration/calibration.h"
#include "app/config/program_config.h"

namespace facet {

/// Takes the IMU's noise and model from the calibration, and the priors of lenses and cameras' rotations if it has
/// them. Reentrant.
inline void take_calibration(const Calibration& calibration, ProgramConfig& config) {
    constexpr double kLeastSigma = 1e-3;     // px
    constexpr double kLeastRelative = 1e-6;  // -, rad: a coefficient that the lens does not have states 0
    config.imu_noise = calibration.noise;
    config.imu_model = calibration.imu_model;
    if (calibration.sigmas.has_value()) {
        config.calibration.focal_sigma = std::max(kLeastRelative, calibration.sigmas->focal);
        config.calibration.principal_sigma_px = std::max(kLeastSigma, calibration.sigmas->principal_px);
        config.calibration.distortion_sigma = std::max(kLeastRelative, calibration.sigmas->distortion);
        config.calibration.late_distortion_sigma = std::max(kLeastRelative, calibration.sigmas->late_distortion);
        config.calibration.camera_rotation_sigma_rad = std::max(kLeastRelative, calibration.sigmas->rotation_rad);
    }
}

}  // namespace facet
