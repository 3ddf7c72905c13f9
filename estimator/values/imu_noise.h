// SPDX-License-Identifier: BSD-2-Clause
// How noisy the IMU is, as its calibration says.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Continuous-time noise of the IMU: white noise and random walk of the biases. Units, ranges and meanings:
/// kImuNoiseFields below.
struct ImuNoise {
    double gyro_noise_rad_per_s_per_sqrt_hz = 1.7e-4;
    double gyro_walk_rad_per_s2_per_sqrt_hz = 2.0e-5;
    double accel_noise_m_per_s2_per_sqrt_hz = 2.0e-3;
    double accel_walk_m_per_s3_per_sqrt_hz = 3.0e-3;
    double rate_hz = 200.0;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kImuNoiseFields = std::to_array<ParameterField<ImuNoise>>({
    {FACET_FIELD(ImuNoise, gyro_noise_rad_per_s_per_sqrt_hz), "rad/s/sqrt(Hz)", 1e-7, 1,
     "Density of the gyroscope's white noise; taken from the calibration unless given."},
    {FACET_FIELD(ImuNoise, gyro_walk_rad_per_s2_per_sqrt_hz), "rad/s^2/sqrt(Hz)", 1e-9, 1,
     "Density of the random walk of the gyroscope's bias; taken from the calibration unless given."},
    {FACET_FIELD(ImuNoise, accel_noise_m_per_s2_per_sqrt_hz), "m/s^2/sqrt(Hz)", 1e-6, 10,
     "Density of the accelerometer's white noise; taken from the calibration unless given."},
    {FACET_FIELD(ImuNoise, accel_walk_m_per_s3_per_sqrt_hz), "m/s^3/sqrt(Hz)", 1e-8, 10,
     "Density of the random walk of the accelerometer's bias; taken from the calibration unless given."},
    {FACET_FIELD(ImuNoise, rate_hz), "Hz", 20, 10000,
     "Nominal sample rate of the IMU; taken from the calibration unless given."},
});

}  // namespace facet
