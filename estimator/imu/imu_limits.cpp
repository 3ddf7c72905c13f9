// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/imu_limits.h"

namespace facet {

Status ImuLimits::validate() const { return validate_fields(kImuLimitFields, *this); }

}  // namespace facet
