// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/config.h"

#include "platform/base/range_check.h"

namespace facet {

Status EstimatorConfig::validate() const {
    FACET_TRY(frontend.validate());
    FACET_TRY(initializer.validate());
    FACET_TRY(window.validate());
    FACET_TRY(calibration.validate());
    FACET_TRY(regularity.validate());
    FACET_TRY(stationarity.validate());
    FACET_TRY(health.validate());
    FACET_TRY(imu_limits.validate());
    const bool noise_valid = in_range(imu_noise.gyro_noise_rad_per_s_per_sqrt_hz, 1e-7, 1.0) &&
                             in_range(imu_noise.gyro_walk_rad_per_s2_per_sqrt_hz, 1e-9, 1.0) &&
                             in_range(imu_noise.accel_noise_m_per_s2_per_sqrt_hz, 1e-6, 10.0) &&
                             in_range(imu_noise.accel_walk_m_per_s3_per_sqrt_hz, 1e-8, 10.0) &&
                             in_range(imu_noise.rate_hz, 20.0, 10000.0);
    return noise_valid ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
