// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/health_config.h"

#include "platform/base/range_check.h"

namespace facet {

Status HealthConfig::validate() const {
    const bool vision = in_range(few_features, 4, 100) && in_range(lost_after_s, 0.2, 30.0) &&
                        in_range(high_vision_chi2, 1.0, 100.0) && in_range(wrong_vision_chi2, 2.0, 1000.0);
    const bool motion = in_range(max_speed_m_per_s, 1.0, 100.0) && in_range(max_velocity_sigma_m_per_s, 0.05, 10.0) &&
                        in_range(max_gyro_bias_rad_per_s, 0.01, 5.0) && in_range(max_accel_bias_m_per_s2, 0.1, 10.0) &&
                        in_range(vibration_m_per_s2, 0.1, 100.0);
    const bool start = in_range(ready_velocity_sigma_m_per_s, 0.01, 1.0) &&
                       in_range(ready_tilt_sigma_rad, 0.001, 0.5) && in_range(grace_s, 0.0, 30.0);
    return vision && motion && start ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
