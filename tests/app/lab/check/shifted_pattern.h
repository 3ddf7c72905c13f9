// SPDX-License-Identifier: BSD-2-Clause
// A textured wall seen from places side by side.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "app/support/rng.h"
#include "platform/base/image_view.h"

namespace facet::test {

inline constexpr int kPatternWidth = 376;
inline constexpr int kPatternHeight = 240;

/// A smooth random pattern, seen from a place moved by (du, dv) pixels.
inline std::vector<std::uint8_t> pattern(int du, int dv, std::uint64_t seed = 1) {
    constexpr int kGrid = 7;
    const auto knot = [&](int i, int j) {
        return static_cast<double>(
            hash64(seed, static_cast<std::uint64_t>(i + 1000), static_cast<std::uint64_t>(j + 1000)) & 0xffU);
    };
    std::vector<std::uint8_t> pixels;
    for (int v = 0; v < kPatternHeight; ++v) {
        for (int u = 0; u < kPatternWidth; ++u) {
            const double x = static_cast<double>(u + du + 700) / kGrid;
            const double y = static_cast<double>(v + dv + 700) / kGrid;
            const int i = static_cast<int>(x);
            const int j = static_cast<int>(y);
            const double a = x - i;
            const double b = y - j;
            const double grey = (1 - b) * ((1 - a) * knot(i, j) + a * knot(i + 1, j)) +
                                b * ((1 - a) * knot(i, j + 1) + a * knot(i + 1, j + 1));
            pixels.push_back(static_cast<std::uint8_t>(std::lround(grey)));
        }
    }
    return pixels;
}

inline ImageView view(const std::vector<std::uint8_t>& pixels) {
    return {pixels.data(), kPatternWidth, kPatternHeight, kPatternWidth};
}

}  // namespace facet::test
