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

/// Units, ranges and meanings: kStationarityFields below.
struct StationarityConfig {
    double duration_s = 0.5;
    double margin = 3.0;
    double gyro_floor_rad_per_s = 0.003;
    double accel_floor_m_per_s2 = 0.03;
    double gyro_mean_rad_per_s = 0.02;
    double gravity_error_m_per_s2 = 0.3;
    double gyro_drift_rad_per_s = 0.003;
    double accel_drift_m_per_s2 = 0.015;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kStationarityFields = std::to_array<ParameterField<StationarityConfig>>({
    {FACET_FIELD(StationarityConfig, duration_s), "s", 0.1, 5,
     "Length of the newest inertial data that are examined for rest; 0.5 s is enough to see a sway of 1 Hz."},
    {FACET_FIELD(StationarityConfig, margin), "-", 1, 20,
     "At rest the IMU's standard deviations are below this many times the sensor's noise combined with the floor."},
    {FACET_FIELD(StationarityConfig, gyro_floor_rad_per_s), "rad/s", 0, 0.5,
     "Standard deviation of the rate that fans and wind cause on a vehicle at rest."},
    {FACET_FIELD(StationarityConfig, accel_floor_m_per_s2), "m/s^2", 0, 5,
     "Standard deviation of the acceleration that fans and wind cause on a vehicle at rest."},
    {FACET_FIELD(StationarityConfig, gyro_mean_rad_per_s), "rad/s", 1e-4, 0.5,
     "Largest mean rate at rest after subtracting the bias: the error of the bias estimate."},
    {FACET_FIELD(StationarityConfig, gravity_error_m_per_s2), "m/s^2", 0.01, 3,
     "Largest difference at rest between g and the mean specific force without bias: errors of bias and scale."},
    {FACET_FIELD(StationarityConfig, gyro_drift_rad_per_s), "rad/s", 0, 0.1,
     "Largest change of the mean rate at rest between the halves of the examined data, beyond noise."},
    {FACET_FIELD(StationarityConfig, accel_drift_m_per_s2), "m/s^2", 0, 1,
     "Largest change of the mean specific force at rest between the halves of the examined data, beyond noise; the "
     "default is less than the slowest sway of a hand."},
});

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

/// Looks at the newest duration_s of samples before a stamp. All of these must hold, on every axis:
///   deviation about the mean <= margin * hypot(noise sqrt(rate), floor)        no shaking beyond the sensor's
///   |mean rate - bias| <= gyro_mean,  ||mean force - bias| - g| <= gravity_error
///   |mean of the later half - mean of the earlier| <= drift + 4 deviations of it no slow sway, no beginning take-off
/// The last one detects slow smooth motion: with the defaults a jerk of 0.12 m/s^3 or a change of the rate of 0.03
/// rad/s^2 is seen, so that a swaying hand (a centimetre at 1 Hz) is motion, but a pure glide is not, nor a turn slower
/// than gyro_mean. The unnoticed motion of a take-off in its first tenths of a second stays below 2 cm/s.
/// Usage, at every frame:
///   Stationarity rest;
///   if (ok(measure_stationarity(buffer, stamp, imu, config, rest)) && rest.may_be_at_rest && no_disparity) ...
/// @return kNotReady if samples do not reach the stamp or do not cover duration_s before it; kDegenerate if there is a
///         gap or a clipped reading in them: nothing is known. out untouched then. Reentrant. No heap.
Status measure_stationarity(const ImuBuffer& buffer, Timestamp stamp, const RestingImu& imu,
                            const StationarityConfig& config, Stationarity& out);

}  // namespace facet
