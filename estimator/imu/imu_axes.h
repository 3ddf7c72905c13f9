// SPDX-License-Identifier: BSD-2-Clause
// Names of an inertial sample's axes.
#pragma once

#include <cstdint>

namespace facet {

/// Axes of a sample, bit k: 0 to 2 gyroscope x, y, z; 3 to 5 accelerometer.
using ImuAxisMask = std::uint8_t;
inline constexpr ImuAxisMask kGyroAxes = 0x07;
inline constexpr ImuAxisMask kAccelAxes = 0x38;

}  // namespace facet
