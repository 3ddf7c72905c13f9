// SPDX-License-Identifier: BSD-2-Clause
// Measuring ranges of the IMU, beyond which its readings say only "at least this much".
#pragma once

#include "estimator/imu/imu_axes.h"
#include "platform/base/parameter_field.h"
#include "platform/base/samples.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kImuLimitFields below. Usage: a member of the estimator's configuration, given to
/// ImuBuffer::clear() with the rate.
struct ImuLimits {
    double gyro_range_rad_per_s = 17.453;
    double accel_range_m_per_s2 = 176.58;

    /// An axis at this share of its range is clipped: analogue stages saturate somewhat before the digital full scale.
    static constexpr double kClipShare = 0.9;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;

    /// Axes of a reading that are clipped. It must be as the sensor gives it: what is corrected for scale and
    /// misalignment has other limits. Reentrant.
    ImuAxisMask clipped_axes(const ImuSample& reading) const;
};

inline constexpr auto kImuLimitFields = std::to_array<ParameterField<ImuLimits>>({
    {FACET_FIELD(ImuLimits, gyro_range_rad_per_s), "rad/s", 0.1, 1000,
     "Full scale of a gyroscope axis; a reading there counts as clipped. Default: ADIS16448, 1000 deg/s."},
    {FACET_FIELD(ImuLimits, accel_range_m_per_s2), "m/s^2", 5, 1e5,
     "Full scale of an accelerometer axis; a reading there counts as clipped. Default: ADIS16448, 18 g."},
});

}  // namespace facet
