// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/imu_limits.h"

#include <cmath>

namespace facet {

Status ImuLimits::validate() const { return validate_fields(kImuLimitFields, *this); }

ImuAxisMask ImuLimits::clipped_axes(const ImuSample& reading) const {
    ImuAxisMask clipped = 0;
    for (int axis = 0; axis < 6; ++axis) {
        const double value = axis < 3 ? reading.w_B[axis] : reading.a_B[axis - 3];
        const double range = axis < 3 ? gyro_range_rad_per_s : accel_range_m_per_s2;
        if (std::abs(value) >= kClipShare * range) {
            clipped |= static_cast<ImuAxisMask>(1U << static_cast<unsigned>(axis));
        }
    }
    return clipped;
}

}  // namespace facet
