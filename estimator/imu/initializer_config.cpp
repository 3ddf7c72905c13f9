// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/initializer_config.h"

namespace facet {
namespace {

/// False for NaN too.
bool in_range(double value, double low, double high) { return value >= low && value <= high; }

}  // namespace

Status InitializerConfig::validate() const {
    const bool valid =
        in_range(min_duration_s, 0.02, 2.0) && in_range(max_duration_s, 0.1, 5.0) && min_duration_s <= max_duration_s &&
        in_range(still_gyro_std_rad_per_s, 1e-4, 1.0) && in_range(still_accel_std_m_per_s2, 1e-3, 5.0) &&
        in_range(still_gyro_mean_rad_per_s, 1e-3, 1.0) && in_range(still_gravity_error_m_per_s2, 0.01, 3.0) &&
        in_range(still_velocity_sigma_m_per_s, 1e-4, 1.0) && in_range(moving_velocity_sigma_m_per_s, 0.1, 50.0) &&
        in_range(still_tilt_sigma_rad, 1e-4, 0.5) && in_range(moving_tilt_sigma_rad, 1e-3, 1.0) &&
        in_range(gyro_bias_sigma_rad_per_s, 1e-4, 1.0) && in_range(still_gyro_bias_sigma_rad_per_s, 1e-5, 1.0) &&
        in_range(accel_bias_sigma_m_per_s2, 1e-3, 5.0);
    return valid ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
