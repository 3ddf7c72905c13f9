// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the first state: gravity, velocity and biases from a short stretch of inertial samples.
#pragma once

#include <string_view>

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kInitializerFields below.
struct InitializerConfig {
    double min_duration_s = 0.1;
    double max_duration_s = 1.0;
    double still_velocity_sigma_m_per_s = 0.05;
    double moving_velocity_sigma_m_per_s = 2.0;
    double still_accel_sigma_m_per_s2 = 0.03;
    double moving_tilt_sigma_rad = 0.2;
    double gyro_bias_sigma_rad_per_s = 0.1;
    double still_gyro_bias_sigma_rad_per_s = 0.005;
    double accel_bias_sigma_m_per_s2 = 0.1;

    /// The condition between fields that does not hold, as a sentence; empty if all hold.
    std::string_view broken_rule() const;
    /// kInvalidArgument if a field is outside its range or a condition between fields does not hold.
    Status validate() const;
};

inline constexpr auto kInitializerFields = std::to_array<ParameterField<InitializerConfig>>({
    {FACET_FIELD(InitializerConfig, min_duration_s), "s", 0.02, 2,
     "Length of inertial data needed before the first frame is taken; a start must take less than a second."},
    {FACET_FIELD(InitializerConfig, max_duration_s), "s", 0.1, 5,
     "Length of inertial data before the first frame from which the first state is computed."},
    {FACET_FIELD(InitializerConfig, still_velocity_sigma_m_per_s), "m/s", 1e-4, 1,
     "Standard deviation of the first velocity, taken as zero, after a start at rest."},
    {FACET_FIELD(InitializerConfig, moving_velocity_sigma_m_per_s), "m/s", 0.1, 50,
     "Standard deviation of the first velocity, taken as zero, after a start in motion."},
    {FACET_FIELD(InitializerConfig, still_accel_sigma_m_per_s2), "m/s^2", 1e-3, 1,
     "Standard deviation of the mean acceleration of a vehicle that counts as still at the start: a slow sway."},
    {FACET_FIELD(InitializerConfig, moving_tilt_sigma_rad), "rad", 1e-3, 1,
     "Standard deviation of the direction of gravity after a start in motion."},
    {FACET_FIELD(InitializerConfig, gyro_bias_sigma_rad_per_s), "rad/s", 1e-4, 1,
     "Standard deviation of the gyroscope bias when it could not be measured at rest."},
    {FACET_FIELD(InitializerConfig, still_gyro_bias_sigma_rad_per_s), "rad/s", 1e-5, 1,
     "Standard deviation of the gyroscope bias measured at rest."},
    {FACET_FIELD(InitializerConfig, accel_bias_sigma_m_per_s2), "m/s^2", 1e-3, 5,
     "Standard deviation of the first accelerometer bias, taken as zero."},
});

}  // namespace facet
