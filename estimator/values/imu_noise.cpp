// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/values/imu_noise.h"

namespace facet {

Status ImuNoise::validate() const { return validate_fields(kImuNoiseFields, *this); }

}  // namespace facet
