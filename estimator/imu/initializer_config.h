// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the first state: gravity, velocity and biases from a short stretch of inertial samples.
#pragma once

#include "platform/base/status.h"

namespace facet {

/// One line a field: meaning [unit] [range] and why this default.
struct InitializerConfig {
    double min_duration_s = 0.1;  ///< inertial data needed before the first frame is taken [0.02, 2]; < 1 s by demand
    double max_duration_s = 1.0;  ///< stretch looked at, the newest before the first frame [0.1, 5]
    double still_gyro_std_rad_per_s = 0.03;  ///< standard deviation below: standing still [1e-4, 1]
    double still_accel_std_m_per_s2 = 0.3;   ///< standard deviation below: standing still [1e-3, 5]
    double still_gyro_mean_rad_per_s = 0.2;  ///< mean rate below: standing still; larger is motion, not bias [1e-3, 1]
    double still_gravity_error_m_per_s2 = 0.7;       ///< | |mean accel| - g | below: standing still [0.01, 3]
    double still_velocity_sigma_m_per_s = 0.05;      ///< prior when still [1e-4, 1]
    double moving_velocity_sigma_m_per_s = 2.0;      ///< prior when moving [0.1, 50]
    double still_tilt_sigma_rad = 0.02;              ///< gravity direction when still: accel bias over g [1e-4, 0.5]
    double moving_tilt_sigma_rad = 0.2;              ///< gravity direction when moving [1e-3, 1]
    double gyro_bias_sigma_rad_per_s = 0.1;          ///< prior of the gyro bias when it could not be measured [1e-4, 1]
    double still_gyro_bias_sigma_rad_per_s = 0.005;  ///< prior of the measured gyro bias [1e-5, 1]
    double accel_bias_sigma_m_per_s2 = 0.1;          ///< prior of the accelerometer bias [1e-3, 5]

    Status validate() const;
};

}  // namespace facet
