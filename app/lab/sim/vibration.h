// SPDX-License-Identifier: BSD-2-Clause
// What rotors do to the inertial samples.
#pragma once

#include <cstdint>
#include <span>

#include "app/lab/sim/imu_synthesis.h"

namespace facet::sim {

/// Four rotors, each a sinusoid whose frequency wanders slowly within the band, in a random direction of its own.
struct Vibration {
    double accel_rms_m_per_s2 = 0.5;   ///< per axis
    double gyro_rms_rad_per_s = 0.02;  ///< per axis
    double low_hz = 80.0;
    double high_hz = 120.0;
};

/// Adds the vibration to the samples, rising over half a second from `from_s` on. The true states stay as they are:
/// such a motion is 2 um and 0.05 mrad wide, which no image shows. Above half the sampling rate it aliases, as in an
/// IMU without a filter.
void add_vibration(const Vibration& vibration, double from_s, std::uint64_t seed, std::span<ImuRecord> records);

}  // namespace facet::sim
