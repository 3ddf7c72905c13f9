// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/noise.h"

#include <algorithm>
#include <cmath>

#include "app/support/rng.h"

namespace facet::sim {
namespace {

std::uint32_t lattice_bits(int x, int y, std::uint32_t seed) {
    return mix32(static_cast<std::uint32_t>(x) * 0x9e3779b1U +
                 mix32(static_cast<std::uint32_t>(y) * 0x85ebca77U + seed));
}

float lattice_gradient(int x, int y, std::uint32_t seed, float dx, float dy) {
    // Eight directions: four diagonals, four axes of equal length.
    constexpr float kA = 1.0F;
    constexpr float kB = 1.41421356F;
    constexpr float kX[8] = {kA, -kA, kA, -kA, kB, -kB, 0.0F, 0.0F};
    constexpr float kY[8] = {kA, kA, -kA, -kA, 0.0F, 0.0F, kB, -kB};
    const std::uint32_t h = lattice_bits(x, y, seed) >> 29;
    return kX[h] * dx + kY[h] * dy;
}

float fade(float t) { return t * t * t * (t * (t * 6.0F - 15.0F) + 10.0F); }
float mix(float a, float b, float t) { return a + t * (b - a); }
int wrap(int i, int period) {
    const int r = i % period;
    return r < 0 ? r + period : r;
}

float solid_octave(float x, float y, float z, std::uint32_t seed) {
    const int ix = static_cast<int>(std::floor(x));
    const int iy = static_cast<int>(std::floor(y));
    const int iz = static_cast<int>(std::floor(z));
    const float fx = fade(x - static_cast<float>(ix));
    const float fy = fade(y - static_cast<float>(iy));
    const float fz = fade(z - static_cast<float>(iz));
    float layers[2];
    for (int k = 0; k < 2; ++k) {
        const std::uint32_t s = mix32(static_cast<std::uint32_t>(iz + k) + seed);
        layers[k] = mix(mix(lattice_value(ix, iy, s), lattice_value(ix + 1, iy, s), fx),
                        mix(lattice_value(ix, iy + 1, s), lattice_value(ix + 1, iy + 1, s), fx), fy);
    }
    return 2.0F * mix(layers[0], layers[1], fz) - 1.0F;
}

}  // namespace

float lattice_value(int x, int y, std::uint32_t seed) {
    return static_cast<float>(lattice_bits(x, y, seed) >> 8) * 0x1.0p-24F;
}

float gradient_noise(float x, float y, int px, int py, std::uint32_t seed) {
    const float gx = x * static_cast<float>(px);
    const float gy = y * static_cast<float>(py);
    const float floor_x = std::floor(gx);
    const float floor_y = std::floor(gy);
    const int x0 = wrap(static_cast<int>(floor_x), px);
    const int y0 = wrap(static_cast<int>(floor_y), py);
    const int x1 = x0 + 1 == px ? 0 : x0 + 1;
    const int y1 = y0 + 1 == py ? 0 : y0 + 1;
    const float dx = gx - floor_x;
    const float dy = gy - floor_y;
    const float u = fade(dx);
    const float top = mix(lattice_gradient(x0, y0, seed, dx, dy), lattice_gradient(x1, y0, seed, dx - 1.0F, dy), u);
    const float low =
        mix(lattice_gradient(x0, y1, seed, dx, dy - 1.0F), lattice_gradient(x1, y1, seed, dx - 1.0F, dy - 1.0F), u);
    return mix(top, low, fade(dy));
}

float fractal_noise(float x, float y, int px, int py, int octaves, std::uint32_t seed, float gain) {
    float sum = 0.0F;
    float amplitude = 0.7F;
    for (int i = 0; i < octaves; ++i) {
        sum += amplitude * gradient_noise(x, y, px << i, py << i, seed + 101U * static_cast<std::uint32_t>(i));
        amplitude *= gain;
    }
    return sum;
}

Cell cell_noise(float x, float y, int px, int py, std::uint32_t seed, float jitter) {
    const float gx = x * static_cast<float>(px);
    const float gy = y * static_cast<float>(py);
    const int cx = static_cast<int>(std::floor(gx));
    const int cy = static_cast<int>(std::floor(gy));
    Cell best{9.0F, 9.0F, 0.0F};
    for (int j = cy - 1; j <= cy + 1; ++j) {
        for (int i = cx - 1; i <= cx + 1; ++i) {
            const int wi = wrap(i, px);
            const int wj = wrap(j, py);
            const float sx = static_cast<float>(i) + 0.5F + jitter * (lattice_value(wi, wj, seed) - 0.5F);
            const float sy = static_cast<float>(j) + 0.5F + jitter * (lattice_value(wi, wj, seed + 7U) - 0.5F);
            const float d = std::sqrt((sx - gx) * (sx - gx) + (sy - gy) * (sy - gy));
            if (d < best.nearest) {
                best = {d, best.nearest, lattice_value(wi, wj, seed + 13U)};
            } else {
                best.second = std::min(best.second, d);
            }
        }
    }
    return best;
}

float solid_noise(float x, float y, float z, int octaves, std::uint32_t seed) {
    float sum = 0.0F;
    float amplitude = 0.6F;
    for (int i = 0; i < octaves; ++i) {
        sum += amplitude * solid_octave(x, y, z, seed + 101U * static_cast<std::uint32_t>(i));
        amplitude *= 0.5F;
        x *= 2.03F;
        y *= 2.03F;
        z *= 2.03F;
    }
    return sum;
}

}  // namespace facet::sim
