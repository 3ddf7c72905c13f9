// SPDX-License-Identifier: BSD-2-Clause
// Periodic procedural noise on the unit square, from which textures tile without seams.
#pragma once

#include <algorithm>
#include <cstdint>

namespace facet::sim {

/// Uniform [0, 1) of a lattice point.
float lattice_value(int x, int y, std::uint32_t seed);

/// Gradient noise with px x py cells in the unit square, period 1, roughly in [-1, 1]. Perlin, "Improving noise", 2002.
float gradient_noise(float x, float y, int px, int py, std::uint32_t seed);

/// Sum of octaves of gradient_noise: cells double and amplitude halves (times `gain` / 0.5) with each; about [-1, 1].
float fractal_noise(float x, float y, int px, int py, int octaves, std::uint32_t seed, float gain = 0.5F);

/// Worley cells of period 1: distances to the nearest and second nearest seed (in cells), and the uniform tone of the
/// nearest.
struct Cell {
    float nearest = 0.0F;
    float second = 0.0F;
    float tone = 0.0F;
};
Cell cell_noise(float x, float y, int px, int py, std::uint32_t seed, float jitter = 1.0F);

/// Solid (3D) value noise with fractal octaves in about [-1, 1], not periodic; for bumps of meshes.
float solid_noise(float x, float y, float z, int octaves, std::uint32_t seed);

/// 0 at a and before, 1 at b and beyond, smooth between; a may be above b.
inline float smooth_step(float a, float b, float x) {
    const float t = std::clamp((x - a) / (b - a), 0.0F, 1.0F);
    return t * t * (3.0F - 2.0F * t);
}

}  // namespace facet::sim
