// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the first state: gravity, velocity and biases from a short stretch of inertial samples.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kInitializerFields below.
struct InitializerConfig {
    /// Standard deviation of the gyroscope bias measured at rest (rad/s).
    static constexpr double kStillGyroBiasSigma_rad_per_s = 0.005;
    /// Standard deviation of the direction of gravity after a start in motion (rad).
    static constexpr double kMovingTiltSigma_rad = 0.2;
    /// Standard deviation of the mean acceleration of a vehicle that counts as still at the start: a slow sway (m/s^2).
    static constexpr double kStillAccelSigma_m_per_s2 = 0.03;
    /// Standard deviation of the first velocity, taken as zero, after a start in motion (m/s).
    static constexpr double kMovingVelocitySigma_m_per_s = 2.0;
    /// Standard deviation of the first velocity, taken as zero, after a start at rest (m/s).
    static constexpr double kStillVelocitySigma_m_per_s = 0.05;
    /// Length of inertial data before the first frame from which the first state is computed (s).
    static constexpr double kMaxDuration_s = 1.0;
    /// Length of inertial data needed before the first frame is taken; a start must take less than a second (s).
    static constexpr double kMinDuration_s = 0.1;
    double gyro_bias_sigma_rad_per_s = 0.1;
    double accel_bias_sigma_m_per_s2 = 0.1;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kInitializerFields = std::to_array<ParameterField<InitializerConfig>>({
    {FACET_FIELD(InitializerConfig, gyro_bias_sigma_rad_per_s), "rad/s", 1e-4, 1,
     "Standard deviation of the gyroscope bias when it could not be measured at rest."},
    {FACET_FIELD(InitializerConfig, accel_bias_sigma_m_per_s2), "m/s^2", 1e-3, 5,
     "Standard deviation of the first accelerometer bias, taken as zero."},
});

}  // namespace facet
