// SPDX-License-Identifier: BSD-2-Clause
// Whether the IMU may be at rest, from its newest samples alone.
#pragma once

#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/preintegration.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/nav_state.h"
#include "platform/base/status.h"

namespace facet {

/// One line a field: meaning [unit] [range] and why this default.
struct StationarityConfig {
    double duration_s = 0.5;  ///< stretch looked at [0.1, 5]: a sway of 1 Hz shows in it
    double margin = 3.0;      ///< a deviation may be this many times the sensor's noise and the floor [1, 20]
    double gyro_floor_rad_per_s = 0.003;  ///< shaking of a vehicle at rest: fans, wind [0, 0.5]
    double accel_floor_m_per_s2 = 0.03;   ///< likewise [0, 5]
    double gyro_mean_rad_per_s = 0.02;    ///< mean rate without bias: error of the bias estimate [1e-4, 0.5]
    double gravity_error_m_per_s2 = 0.3;  ///< | |mean force without bias| - g |: bias error, scale [0.01, 3]
    double gyro_drift_rad_per_s = 0.003;  ///< change of the mean from one half to the other beyond noise [0, 0.1]
    double accel_drift_m_per_s2 = 0.015;  ///< likewise [0, 1]: less than the slowest sway of a hand

    Status validate() const;
};

/// What the samples say.
struct Stationarity {
    /// Nothing in the samples speaks against rest. Steady straight flight without vibration looks the same: to be combined
    /// with what the images say (little disparity).
    bool may_be_at_rest = false;
    double measure = 0.0;  ///< largest statistic over its limit: below 1 at rest
};

/// Looks at the newest duration_s of samples before a stamp. All of these must hold, on every axis:
///   deviation about the mean <= margin * hypot(noise sqrt(rate), floor)        no shaking beyond the sensor's
///   |mean rate - bias| <= gyro_mean,  ||mean force - bias| - g| <= gravity_error
///   |mean of the later half - mean of the earlier| <= drift + 4 deviations of it  no slow sway, no beginning take-off
/// The last one is what tells slow smooth motion: with the defaults a jerk of 0.12 m/s^3 or a change of the rate of 0.03
/// rad/s^2 is seen, so that a swaying hand (a centimetre at 1 Hz) is motion, but a pure glide is not, nor a turn slower
/// than gyro_mean. The unnoticed motion of a take-off in its first tenths of a second stays below 2 cm/s.
/// Usage, at every frame:
///   Stationarity rest;
///   if (ok(measure_stationarity(imu, stamp, noise, state.bias, config, rest)) && rest.may_be_at_rest && no_disparity) ...
/// @return kNotReady if samples do not reach the stamp or do not cover duration_s before it; kDegenerate if there is a gap
///         or a clipped reading in them: nothing is known. out untouched then. Reentrant. No heap.
Status measure_stationarity(const ImuBuffer& buffer, Timestamp stamp, const ImuNoise& noise, const ImuBias& bias,
                            const StationarityConfig& config, Stationarity& out);

}  // namespace facet
