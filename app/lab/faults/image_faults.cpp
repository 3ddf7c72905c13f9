// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/image_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "app/support/rng.h"

namespace facet {
namespace {

constexpr float kBlackLevel = 2.0F;
constexpr float kWallLevel = 120.0F;
constexpr float kReadNoise = 1.5F;    // grey values
constexpr double kSmearCentre = 0.4;  // of the width
constexpr double kSmearRadius = 0.4;  // of the height
constexpr int kSmearReach = 12;       // px to every side
constexpr float kVeil = 150.0F;

std::uint8_t grey(float value) { return static_cast<std::uint8_t>(std::clamp(std::round(value), 0.0F, 255.0F)); }

void fill_noisily(float level, float sigma, std::uint64_t seed, GreyImage& image) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        image.pixels[i] = grey(level + sigma * irwin_hall_normal(hash64(seed, i)));
    }
}

/// (width + 1) x (height + 1) sums of all pixels above and to the left; modulo 2^32, which differences do not mind.
std::vector<std::uint32_t> summed_area(const GreyImage& image) {
    const auto width = static_cast<std::size_t>(image.width);
    const auto height = static_cast<std::size_t>(image.height);
    std::vector<std::uint32_t> sums((width + 1) * (height + 1), 0);
    for (std::size_t v = 0; v < height; ++v) {
        std::uint32_t row = 0;
        for (std::size_t u = 0; u < width; ++u) {
            row += image.pixels[v * width + u];
            sums[(v + 1) * (width + 1) + u + 1] = sums[v * (width + 1) + u + 1] + row;
        }
    }
    return sums;
}

}  // namespace

void black_out(std::uint64_t seed, GreyImage& image) { fill_noisily(kBlackLevel, kReadNoise, seed, image); }

void whiten(std::uint64_t seed, GreyImage& image) { fill_noisily(kWallLevel, kReadNoise, seed, image); }

void expose(double gain, GreyImage& image) {
    std::array<std::uint8_t, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        table[i] = static_cast<std::uint8_t>(std::min(255.0, std::round(gain * static_cast<double>(i))));
    }
    for (std::uint8_t& pixel : image.pixels) {
        pixel = table[pixel];
    }
}

void add_pixel_noise(double sigma, std::uint64_t seed, GreyImage& image) {
    const auto scale = static_cast<float>(sigma);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        image.pixels[i] = grey(static_cast<float>(image.pixels[i]) + scale * irwin_hall_normal(hash64(seed, i)));
    }
}

void smear(GreyImage& image) {
    const std::vector<std::uint32_t> sums = summed_area(image);
    const int width = image.width;
    const int height = image.height;
    const double radius = kSmearRadius * height;
    const auto sum = [&](int u, int v) {  // of all pixels above and to the left
        return sums[static_cast<std::size_t>(v) * static_cast<std::size_t>(width + 1) + static_cast<std::size_t>(u)];
    };
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
            if (std::hypot(u - kSmearCentre * width, v - 0.5 * height) > radius) {
                continue;
            }
            const int u0 = std::max(0, u - kSmearReach);
            const int v0 = std::max(0, v - kSmearReach);
            const int u1 = std::min(width, u + kSmearReach + 1);
            const int v1 = std::min(height, v + kSmearReach + 1);
            const std::uint32_t total = sum(u1, v1) - sum(u0, v1) - sum(u1, v0) + sum(u0, v0);
            const float mean = static_cast<float>(total) / static_cast<float>((u1 - u0) * (v1 - v0));
            image.pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)] =
                grey(0.5F * (mean + kVeil));
        }
    }
}

void copy_image(const ImageView& view, GreyImage& image) {
    image.width = view.empty() ? 0 : view.width;
    image.height = view.empty() ? 0 : view.height;
    const auto width = static_cast<std::size_t>(image.width);
    image.pixels.resize(width * static_cast<std::size_t>(image.height));
    for (int v = 0; v < image.height; ++v) {
        std::memcpy(image.pixels.data() + static_cast<std::size_t>(v) * width, view.row(v), width);
    }
}

}  // namespace facet
