// SPDX-License-Identifier: BSD-2-Clause
// Whether the IMU may be at rest, from its newest samples alone.
#pragma once

#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/preintegration.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/nav_state.h"
#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Length of the newest inertial data that are examined for rest (s): enough to see a sway of 1 Hz.
inline constexpr double kRestDuration_s = 0.5;

/// What the samples say.
struct Stationarity {
    /// Nothing in the samples contradicts rest. Steady straight flight without vibration looks the same, so combine it
    /// with what the images show (little disparity).
    bool may_be_at_rest = false;
    double measure = 0.0;  ///< largest statistic over its limit: below 1 at rest
};

/// What the IMU is known to measure at rest, the attitude apart.
struct RestingImu {
    const ImuNoise& noise;
    ImuBias bias;             ///< as estimated
    double gravity_m_per_s2;  ///< g
};

/// Looks at the newest kRestDuration_s of samples before a stamp. All of these must hold, on every axis:
///   deviation about the mean <= 3 hypot(noise sqrt(rate), floor)        no shaking beyond the sensor's
///   |mean rate - bias| <= gyro_mean,  ||mean force - bias| - g| <= gravity_error
///   |mean of the later half - mean of the earlier| <= drift + 4 deviations of it no slow sway, no beginning take-off
/// The last one detects slow smooth motion: a jerk of 0.12 m/s^3 or a change of the rate of 0.03
/// rad/s^2 is seen, so that a swaying hand (a centimetre at 1 Hz) is motion, but a pure glide is not, nor a turn slower
/// than gyro_mean. The unnoticed motion of a take-off in its first tenths of a second stays below 2 cm/s.
/// Usage, at every frame:
///   Stationarity rest;
///   if (ok(measure_stationarity(buffer, stamp, imu, rest)) && rest.may_be_at_rest && no_disparity) ...
/// @return kNotReady if samples do not reach the stamp or do not cover kRestDuration_s before it; kDegenerate if there
///         is a gap or a clipped reading in them: nothing is known. out untouched then. Reentrant. No heap.
Status measure_stationarity(const ImuBuffer& buffer, Timestamp stamp, const RestingImu& imu, Stationarity& out);

}  // namespace facet
