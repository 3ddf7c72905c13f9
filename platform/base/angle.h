// SPDX-License-Identifier: BSD-2-Clause
// Degrees, for people and data sheets; everything inside is in radians.
#pragma once

#include <numbers>

namespace facet {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;

}  // namespace facet
