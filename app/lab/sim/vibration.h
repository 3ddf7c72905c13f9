// SPDX-License-Identifier: BSD-2-Clause
// Rotors on the inertial samples of a simulated flight.
#pragma once

#include <cstdint>
#include <span>

#include "app/lab/faults/rotor_vibration.h"
#include "app/lab/sim/imu_synthesis.h"

namespace facet::sim {

/// Adds the vibration of rotors to the samples. kIdle: they idle from the first sample to the last; kFlight: they idle
/// until take-off and turn as in flight from half a second later, the powers passing over linearly. The true states
/// stay as they are: in the air the body shakes by 0.5 mrad and 0.06 mm rms, of which the images show nothing.
void add_vibration(VibrationKind kind, double take_off_s, std::uint64_t seed, std::span<ImuRecord> records);

}  // namespace facet::sim
