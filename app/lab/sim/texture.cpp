// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/texture.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "platform/base/assert.h"

namespace facet::sim {

Texture::Texture(int size, const std::vector<float>& base) {
    FACET_ASSERT(size > 0 && std::has_single_bit(static_cast<unsigned>(size)));
    FACET_ASSERT(base.size() == static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
    log2_size_ = std::countr_zero(static_cast<unsigned>(size));
    std::vector<float> level = base;
    for (int n = size;; n /= 2) {
        offsets_.push_back(static_cast<std::uint32_t>(texels_.size()));
        for (const float value : level) {
            texels_.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * 255.0F)));
        }
        if (n == 1) {
            return;
        }
        const int half = n / 2;
        std::vector<float> coarse(static_cast<std::size_t>(half) * half);
        for (int y = 0; y < half; ++y) {
            for (int x = 0; x < half; ++x) {
                const float* at = level.data() + static_cast<std::size_t>(2 * y) * n + 2 * x;
                coarse[static_cast<std::size_t>(y) * half + x] = 0.25F * (at[0] + at[1] + at[n] + at[n + 1]);
            }
        }
        level = std::move(coarse);
    }
}

float Texture::bilinear(int level, float s, float t) const {
    const int shift = log2_size_ - level;
    const int mask = (1 << shift) - 1;
    const auto scale = static_cast<float>(1 << shift);
    // One period on top keeps the argument positive, so that truncation is floor.
    const float x = (s + 1.0F) * scale - 0.5F;
    const float y = (t + 1.0F) * scale - 0.5F;
    const int ix = static_cast<int>(x);
    const int iy = static_cast<int>(y);
    const float fx = x - static_cast<float>(ix);
    const float fy = y - static_cast<float>(iy);
    const int x0 = ix & mask;
    const int x1 = (ix + 1) & mask;
    const std::uint8_t* base = texels_.data() + offsets_[level];
    const std::uint8_t* top = base + (static_cast<std::size_t>(iy & mask) << shift);
    const std::uint8_t* low = base + (static_cast<std::size_t>((iy + 1) & mask) << shift);
    const float a = static_cast<float>(top[x0]) + fx * static_cast<float>(top[x1] - top[x0]);
    const float b = static_cast<float>(low[x0]) + fx * static_cast<float>(low[x1] - low[x0]);
    return a + fy * (b - a);
}

float Texture::sample(float s, float t, float footprint) const {
    const float texels = std::max(footprint * static_cast<float>(1 << log2_size_), 1.0F);
    // log2 from the exponent and a linear mantissa: within 0.09, continuous, cheap.
    const auto bits = std::bit_cast<std::uint32_t>(texels);
    const float lod = static_cast<float>(bits) * 0x1.0p-23F - 127.0F;
    s = fraction(s);
    t = fraction(t);
    const int level = std::min(static_cast<int>(lod), log2_size_);
    const float fine = bilinear(level, s, t);
    const float blend = lod - static_cast<float>(level);
    if (blend < 0.05F || level == log2_size_) {
        return fine;
    }
    return fine + blend * (bilinear(level + 1, s, t) - fine);
}

}  // namespace facet::sim
