// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/imu_limits.h"

#include "platform/base/range_check.h"

namespace facet {

Status ImuLimits::validate() const {
    const bool valid = in_range(gyro_range_rad_per_s, 0.1, 1000.0) && in_range(accel_range_m_per_s2, 5.0, 1e5);
    return valid ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
