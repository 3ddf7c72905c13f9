// SPDX-License-Identifier: BSD-2-Clause
// Grey texture maps with mip levels: one unit square, repeated permanently.
#pragma once

#include <cstdint>
#include <vector>

namespace facet::sim {

/// Square texture of 2^n texels, 8 bits, filtered trilinearly; period 1 in both directions. Sampling is reentrant and
/// uses no heap.
class Texture {
public:
    Texture() = default;
    /// @param size   power of two
    /// @param base   size * size values in [0, 1], row by row, clamped
    Texture(int size, const std::vector<float>& base);

    int size() const { return 1 << log2_size_; }

    /// Mean of the texture around (s, t) over about `footprint` (in units of the square), in [0, 255]. |s|, |t| < 2^31.
    float sample(float s, float t, float footprint) const;

private:
    /// x - floor(x); |x| < 2^31.
    static float fraction(float x) {
        const float rest = x - static_cast<float>(static_cast<int>(x));
        return rest < 0.0F ? rest + 1.0F : rest;
    }
    float bilinear(int level, float s, float t) const;

    int log2_size_ = 0;
    std::vector<std::uint8_t> texels_;    ///< all levels, finest first
    std::vector<std::uint32_t> offsets_;  ///< of each level
};

}  // namespace facet::sim
