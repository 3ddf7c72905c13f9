// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/patterns.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "app/lab/sim/noise.h"
#include "app/lab/sim/parallel.h"
#include "app/support/rng.h"

namespace facet::sim {
namespace {

float mix(float a, float b, float t) { return a + t * (b - a); }
float fraction(float x) { return x - std::floor(x); }
/// Distance to the nearest border of the unit cell that holds x.
float to_border(float x) { return std::min(fraction(x), 1.0F - fraction(x)); }
float speckle(float x, float y, int n, std::uint32_t seed) {
    return lattice_value(static_cast<int>(x * static_cast<float>(n)), static_cast<int>(y * static_cast<float>(n)),
                         seed) -
           0.5F;
}

float plaster(float x, float y, std::uint32_t seed, float contrast) {
    const float stain = fractal_noise(x, y, 3, 3, 7, seed, 0.6F);
    const float pits =
        smooth_step(0.32F, 0.12F, cell_noise(x, y, 40, 40, seed + 3).nearest) *
        smooth_step(0.55F, 0.9F, lattice_value(static_cast<int>(x * 40), static_cast<int>(y * 40), seed + 5));
    return 0.62F + contrast * (0.45F * stain - 0.35F * pits + 0.12F * speckle(x, y, 512, seed));
}

float brick(float x, float y, std::uint32_t seed) {
    constexpr int kRows = 18;
    constexpr int kColumns = 8;
    const float warp = 0.05F * gradient_noise(x, y, 16, 16, seed);
    const float row = y * kRows + warp;
    const int j = static_cast<int>(std::floor(row));
    const float column = x * kColumns + ((j & 1) != 0 ? 0.5F : 0.0F) + warp;
    const int i = static_cast<int>(std::floor(column)) & (kColumns - 1);
    const float tone = lattice_value(i, (j + kRows) % kRows, seed + 1);
    const float grain = fractal_noise(x, y, 24, 24, 5, seed + 2, 0.65F);
    const float edge = std::min(to_border(column) * kRows / kColumns, to_border(row)) + 0.02F * grain;
    const float face = 0.26F + 0.4F * tone + 0.24F * grain + 0.08F * speckle(x, y, 512, seed);
    return mix(0.66F + 0.25F * grain, face, smooth_step(0.05F, 0.09F, edge));
}

float planks(float x, float y, std::uint32_t seed) {
    constexpr int kCount = 12;
    const float across = x * kCount;
    const int i = static_cast<int>(std::floor(across)) % kCount;
    const float cut = lattice_value(i, 1, seed);
    const float along = fraction(y + cut) * 2.0F;
    const int piece = static_cast<int>(along);
    const float tone = lattice_value(i, 10 + piece, seed);
    const auto shift = static_cast<std::uint32_t>(i * 2 + piece) * 17U + seed;
    const float wave = x + 0.02F * gradient_noise(x, y, 4, 6, shift);
    const float grain = fractal_noise(wave, y, 96, 3, 3, shift, 0.7F) + 0.4F * fractal_noise(x, y, 16, 8, 5, shift);
    const float knot_distance =
        std::hypot((fraction(across) - 0.3F - 0.4F * cut) * 0.8F, (fraction(along) - 0.2F - 0.6F * tone) * 6.0F);
    const float knot = smooth_step(0.22F, 0.1F, knot_distance) * (0.6F + 0.4F * std::sin(90.0F * knot_distance));
    const float gap = std::min(to_border(across), 4.0F * to_border(along));
    const float nail_x = std::min(std::abs(fraction(across) - 0.2F), std::abs(fraction(across) - 0.8F));
    const float nail = smooth_step(0.07F, 0.04F, std::hypot(nail_x, (to_border(along) - 0.04F) * 6.0F));
    const float face = 0.28F + 0.42F * tone + 0.28F * grain - 0.35F * knot;
    return mix(0.06F, face, smooth_step(0.015F, 0.04F, gap)) * (1.0F - 0.75F * nail);
}

float tiles(float x, float y, std::uint32_t seed) {
    constexpr int kCount = 8;
    const float tx = x * kCount;
    const float ty = y * kCount;
    const int i = static_cast<int>(tx);
    const int j = static_cast<int>(ty);
    const float tone = lattice_value(i, j, seed);
    const float kind = lattice_value(i, j, seed + 1);
    const float marble = fractal_noise(x, y, 10, 10, 6, seed + 2 + static_cast<std::uint32_t>(i * 8 + j), 0.6F);
    float face = 0.45F + 0.3F * tone + 0.28F * marble;
    const float u = fraction(tx) - 0.5F;
    const float v = fraction(ty) - 0.5F;
    if (kind > 0.72F) {
        face = std::abs(u) + std::abs(v) < 0.36F ? 0.15F + 0.15F * marble : face;
    } else if (kind < 0.14F) {
        face *= 0.42F;
    } else if (kind < 0.24F) {
        const float ring = std::hypot(u, v);
        face = ring > 0.22F && ring < 0.32F ? 0.2F : face;
    }
    const float edge = std::min(to_border(tx), to_border(ty));
    return mix(0.16F, face, smooth_step(0.018F, 0.03F, edge)) + 0.06F * speckle(x, y, 512, seed);
}

float stone(float x, float y, std::uint32_t seed) {
    const float wx = x + 0.012F * fractal_noise(x, y, 8, 8, 3, seed);
    const float wy = y + 0.012F * fractal_noise(x, y, 8, 8, 3, seed + 1);
    const Cell cell = cell_noise(wx, wy, 7, 11, seed + 2, 0.85F);
    const float rough = fractal_noise(x, y, 14, 14, 6, seed + 3, 0.7F);
    const float face = 0.28F + 0.42F * cell.tone + 0.38F * rough;
    return mix(0.16F + 0.2F * rough, face, smooth_step(0.03F, 0.1F, cell.second - cell.nearest + 0.02F * rough)) +
           0.06F * speckle(x, y, 512, seed);
}

float concrete(float x, float y, std::uint32_t seed) {
    const float stain = fractal_noise(x, y, 4, 4, 7, seed, 0.62F);
    const float crack_field = std::abs(fractal_noise(x, y, 3, 3, 5, seed + 1, 0.6F));
    const float crack =
        smooth_step(0.018F, 0.004F, crack_field) * smooth_step(-0.1F, 0.2F, gradient_noise(x, y, 4, 4, seed + 2));
    const float seam = smooth_step(0.008F, 0.003F, std::min(to_border(x * 2.0F) * 0.5F, to_border(y * 3.0F) / 3.0F));
    const float hole = smooth_step(
        0.022F, 0.017F, std::hypot(fraction(x * 4.0F) * 0.25F - 0.125F, fraction(y * 3.0F) / 3.0F - 0.1667F));
    const float drip = 0.2F * fractal_noise(x, y, 40, 2, 4, seed + 4) * smooth_step(0.0F, 0.5F, stain);
    const float face = 0.52F + 0.3F * stain + drip + 0.1F * speckle(x, y, 512, seed);
    return face * (1.0F - 0.7F * crack) * (1.0F - 0.5F * seam) * (1.0F - 0.75F * hole);
}

float fabric(float x, float y, std::uint32_t seed) {
    const float u = x * 6.0F;
    const float v = y * 6.0F;
    const float diamond = std::abs(fraction(u) - 0.5F) + std::abs(fraction(v) - 0.5F);
    const int ring = static_cast<int>(diamond * 6.0F + 0.6F * gradient_noise(x, y, 24, 24, seed));
    const float tone = lattice_value(ring, (static_cast<int>(u) * 7 + static_cast<int>(v) * 3) % 11, seed);
    const float weave = 0.5F + 0.5F * std::sin(x * 6.2831853F * 128.0F) * std::sin(y * 6.2831853F * 128.0F);
    return 0.15F + 0.6F * tone + 0.2F * fractal_noise(x, y, 8, 8, 6, seed + 1, 0.65F) + 0.1F * (weave - 0.5F);
}

float carton(float x, float y, std::uint32_t seed) {
    float value = 0.55F + 0.12F * fractal_noise(x, y, 2, 30, 4, seed) + 0.12F * fractal_noise(x, y, 4, 4, 6, seed + 1);
    if (std::abs(x - 0.5F) < 0.06F) {
        value = 0.42F + 0.1F * gradient_noise(x, y, 4, 40, seed + 2);  // tape
    }
    for (std::uint32_t k = 0; k < 3; ++k) {  // labels: a light field, a bar code, lines of print
        const float cx = 0.08F + 0.55F * lattice_value(static_cast<int>(k), 0, seed + 9);
        const float cy =
            0.06F + 0.28F * static_cast<float>(k) + 0.08F * lattice_value(static_cast<int>(k), 1, seed + 9);
        const float u = (x - cx) / 0.32F;
        const float v = (y - cy) / 0.2F;
        if (u < 0.0F || u > 1.0F || v < 0.0F || v > 1.0F) {
            continue;
        }
        value = 0.88F;
        if (v > 0.55F && v < 0.9F && u > 0.08F && u < 0.92F) {
            value = lattice_value(static_cast<int>(u * 36.0F), static_cast<int>(k), seed + 10) > 0.5F ? 0.08F : 0.88F;
        } else if (v > 0.1F && v < 0.5F && fraction(v * 10.0F) > 0.4F && u > 0.08F && u < 0.9F) {
            value = lattice_value(static_cast<int>(u * 22.0F), static_cast<int>(v * 10.0F), seed + 11) > 0.35F ? 0.12F
                                                                                                               : 0.88F;
        }
    }
    return value + 0.05F * speckle(x, y, 256, seed);
}

float metal(float x, float y, std::uint32_t seed) {
    const float u = x * 3.0F;
    const float v = y * 4.0F;
    const float tone = lattice_value(static_cast<int>(u), static_cast<int>(v), seed);
    const float rust = fractal_noise(x, y, 6, 3, 6, seed + 1, 0.66F);
    const float streak = fractal_noise(x, y, 48, 3, 4, seed + 2) * smooth_step(-0.1F, 0.4F, rust);
    float face = 0.4F + 0.25F * tone + 0.14F * fractal_noise(x, y, 3, 60, 3, seed + 4) - 0.3F * streak;
    face = mix(face, 0.2F + 0.25F * fractal_noise(x, y, 30, 30, 5, seed + 3, 0.7F), smooth_step(0.12F, 0.3F, rust));
    const float seam = std::min(to_border(u) / 3.0F, to_border(v) / 4.0F);
    const float rivet_u = fraction(u * 6.0F) - 0.5F;
    const float rivet_v = fraction(v * 5.0F) - 0.5F;
    const bool along = (to_border(u) < 0.17F) || (to_border(v) < 0.2F);
    const float rivet = along ? smooth_step(0.26F, 0.18F, std::hypot(rivet_u, rivet_v)) : 0.0F;
    face = mix(face, rivet_v < 0.0F ? 0.85F : 0.15F, 0.7F * rivet);
    return mix(0.1F, face, smooth_step(0.002F, 0.006F, seam));
}

float earth(float x, float y, std::uint32_t seed) {
    const Cell large = cell_noise(x, y, 21, 21, seed);
    const Cell small = cell_noise(x, y, 67, 67, seed + 1);
    const float soil = fractal_noise(x, y, 8, 8, 6, seed + 2, 0.75F);
    const float pebble = smooth_step(0.42F, 0.36F, large.nearest) * smooth_step(0.62F, 0.66F, large.tone);
    const float gravel = smooth_step(0.45F, 0.36F, small.nearest);
    float value = 0.32F + 0.4F * soil;
    value = mix(value, 0.18F + 0.5F * small.tone - 0.3F * small.nearest, 0.75F * gravel);
    value = mix(value, 0.25F + 0.9F * (large.tone - 0.4F) + 0.25F * soil - 0.5F * large.nearest, pebble);
    return value + 0.08F * speckle(x, y, 512, seed);
}

float hazard(float x, float y, std::uint32_t seed) {
    const float wear = fractal_noise(x, y, 5, 5, 7, seed, 0.68F);
    const bool dark = fraction(2.0F * x + 4.0F * y) > 0.5F;
    const float paint = dark ? 0.1F : 0.8F;
    return mix(paint, 0.42F + 0.3F * wear, smooth_step(0.12F, 0.2F, wear)) + 0.08F * wear;
}

float panel(float x, float y, std::uint32_t seed) {
    const float u = x * 4.0F;
    const float v = y * 4.0F;
    const float tone = lattice_value(static_cast<int>(u), static_cast<int>(v), seed);
    const Cell pit = cell_noise(x, y, 60, 60, seed + 1);
    const float worm = smooth_step(0.3F, 0.2F, pit.nearest) * smooth_step(0.45F, 0.55F, pit.tone);
    const float stain = fractal_noise(x, y, 3, 3, 6, seed + 2, 0.6F);
    const float face = 0.6F + 0.15F * tone - 0.3F * worm + 0.18F * stain;
    return mix(0.25F, face, smooth_step(0.012F, 0.02F, std::min(to_border(u), to_border(v))));
}

float books(float x, float y, std::uint32_t seed) {
    constexpr int kRows = 2;
    constexpr int kSpines = 26;
    const int row = static_cast<int>(y * kRows);
    const float v = fraction(y * kRows);
    const float place = x * kSpines + 0.35F * std::sin(x * 6.2831853F * 9.0F + static_cast<float>(row));
    const int i = static_cast<int>(std::floor(place + kSpines)) % kSpines;
    const float tall = 0.62F + 0.3F * lattice_value(i, row, seed);
    if (v < 0.05F) {
        return 0.3F;
    }
    if (v > tall) {
        return 0.04F;
    }
    const float u = fraction(place);
    float tone = 0.1F + 0.8F * lattice_value(i, row, seed + 1);
    const float band = lattice_value(i, row, seed + 2);
    if (std::abs(v - 0.15F - 0.4F * band) < 0.04F || (v > 0.5F && v < 0.55F && band > 0.5F)) {
        tone = 1.0F - tone;
    }
    if (u > 0.35F && u < 0.65F && v > 0.2F && v < tall - 0.12F &&
        lattice_value(i * 31 + row, static_cast<int>(v * 60.0F), seed + 3) > 0.5F) {
        tone = tone > 0.5F ? tone - 0.45F : tone + 0.45F;
    }
    return mix(0.03F, tone, smooth_step(0.03F, 0.1F, std::min(u, 1.0F - u))) +
           0.06F * fractal_noise(x, y, 30, 30, 3, seed);
}

float poster(float x, float y, std::uint32_t seed) {
    if (std::min(to_border(x), to_border(y)) < 0.025F) {
        return 0.92F;
    }
    RandomStream random(seed, 77);
    float value = random.uniform() > 0.5 ? 0.75F : 0.25F;
    for (int k = 0; k < 16; ++k) {
        const auto cx = static_cast<float>(random.uniform());
        const auto cy = static_cast<float>(random.uniform(0.3, 1.0));
        const auto a = static_cast<float>(random.uniform(0.04, 0.22));
        const auto b = static_cast<float>(random.uniform(0.04, 0.22));
        const auto angle = static_cast<float>(random.uniform(0.0, 3.14));
        const auto tone = static_cast<float>(random.uniform(0.03, 0.95));
        const int kind = random.index(4);
        const float u = (std::cos(angle) * (x - cx) + std::sin(angle) * (y - cy)) / a;
        const float v = (std::cos(angle) * (y - cy) - std::sin(angle) * (x - cx)) / b;
        const float r = std::hypot(u, v);
        const bool box = std::abs(u) < 1.0F && std::abs(v) < 1.0F;
        if ((kind == 0 && box) || (kind == 1 && r < 1.0F) || (kind == 2 && box && fraction(3.0F * u) < 0.5F) ||
            (kind == 3 && r < 1.0F && r > 0.6F)) {
            value = tone;
        }
    }
    if (y < 0.28F && y > 0.06F && x > 0.08F && x < 0.92F) {  // print
        const float line = y / 0.035F;
        const bool ink =
            fraction(line) > 0.45F && lattice_value(static_cast<int>(x * 70.0F), static_cast<int>(line), seed) > 0.4F;
        value = ink ? 0.08F : 0.85F;
    }
    return value + 0.05F * fractal_noise(x, y, 6, 6, 6, seed, 0.7F);
}

float photo(float x, float y, std::uint32_t seed) {
    if (std::min(to_border(x), to_border(y)) < 0.02F) {
        return 0.08F;
    }
    float value = 0.65F + 0.3F * y + 0.25F * fractal_noise(x, y, 2, 4, 5, seed);
    for (int k = 0; k < 4; ++k) {  // ridges, nearer ones lower and rougher
        const auto s = seed + 50U * static_cast<std::uint32_t>(k);
        const float crest = 0.75F - 0.17F * static_cast<float>(k) + 0.3F * fractal_noise(x, 0.3F, 3, 2, 7, s, 0.55F);
        if (y < crest) {
            value = 0.5F - 0.1F * static_cast<float>(k) + 0.55F * fractal_noise(x, y, 8, 8, 6, s + 7, 0.75F);
        }
    }
    if (y < 0.3F) {  // houses
        const int house = static_cast<int>(x * 9.0F);
        const float top = 0.1F + 0.18F * lattice_value(house, 3, seed);
        const float u = fraction(x * 9.0F);
        if (y < top && u > 0.1F && u < 0.9F) {
            const bool pane = fraction(u * 4.0F) > 0.45F && fraction(y * 28.0F) > 0.5F;
            value = pane ? 0.05F : 0.35F + 0.6F * lattice_value(house, 4, seed);
        }
    }
    return value;
}

float window(float x, float y, std::uint32_t seed) {
    const float bar = std::min(to_border(x * 2.0F) * 0.5F, to_border(y * 3.0F) / 3.0F);
    if (bar < 0.02F) {
        return 0.35F;
    }
    const int house = static_cast<int>(x * 7.0F);
    const float roof = 0.25F + 0.3F * lattice_value(house, 1, seed);
    if (y < roof) {
        const bool pane = fraction(x * 28.0F) > 0.5F && fraction(y * 24.0F) > 0.5F;
        return pane ? 0.3F : 0.45F + 0.35F * lattice_value(house, 2, seed);
    }
    return 0.85F + 0.2F * fractal_noise(x, y, 2, 3, 5, seed);
}

float door(float x, float y, std::uint32_t seed) {
    const float u = fraction(x * 2.0F);
    const float v = fraction(y * 3.0F);
    const float border = std::min(std::min(u, 1.0F - u), std::min(v, 1.0F - v));
    const float grain = fractal_noise(x, y, 48, 2, 4, seed, 0.7F);
    float value = 0.36F + 0.2F * grain;
    if (border > 0.16F) {
        value = 0.48F + 0.2F * grain;
    } else if (border > 0.13F) {
        value = 0.12F;
    }
    const float knob = std::hypot(x - 0.9F, (y - 0.47F) * 2.0F);
    return knob < 0.035F ? 0.9F : value;
}

float evaluate(Pattern pattern, float x, float y, std::uint32_t seed) {
    switch (pattern) {
        case Pattern::kPlain: return plaster(x, y, seed, 0.12F);
        case Pattern::kPlaster: return plaster(x, y, seed, 1.0F);
        case Pattern::kBrick: return brick(x, y, seed);
        case Pattern::kPlanks: return planks(x, y, seed);
        case Pattern::kTiles: return tiles(x, y, seed);
        case Pattern::kStone: return stone(x, y, seed);
        case Pattern::kConcrete: return concrete(x, y, seed);
        case Pattern::kFabric: return fabric(x, y, seed);
        case Pattern::kCarton: return carton(x, y, seed);
        case Pattern::kMetal: return metal(x, y, seed);
        case Pattern::kEarth: return earth(x, y, seed);
        case Pattern::kHazard: return hazard(x, y, seed);
        case Pattern::kPanel: return panel(x, y, seed);
        case Pattern::kBooks: return books(x, y, seed);
        case Pattern::kPoster: return poster(x, y, seed);
        case Pattern::kPhoto: return photo(x, y, seed);
        case Pattern::kWindow: return window(x, y, seed);
        case Pattern::kDoor: return door(x, y, seed);
        case Pattern::kBlotches: return 0.5F + 0.6F * fractal_noise(x, y, 4, 4, 5, seed, 0.55F);
    }
    return 0.5F;
}

}  // namespace

Texture bake_pattern(Pattern pattern, std::uint32_t seed, int size, int threads) {
    std::vector<float> base(static_cast<std::size_t>(size) * size);
    const float scale = 1.0F / static_cast<float>(size);
    parallel_for(size, threads, [&](int row) {
        for (int column = 0; column < size; ++column) {
            const float x = (static_cast<float>(column) + 0.5F) * scale;
            const float y = (static_cast<float>(row) + 0.5F) * scale;
            base[static_cast<std::size_t>(row) * size + column] = evaluate(pattern, x, y, seed);
        }
    });
    return Texture(size, base);
}

}  // namespace facet::sim
