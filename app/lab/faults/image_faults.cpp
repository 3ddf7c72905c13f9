// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/image_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "app/support/rng.h"

namespace facet {
namespace {

constexpr float kBlackLevel = 2.0F;
constexpr float kReadNoise = 1.5F;  // grey values

}  // namespace

void black_out(std::uint64_t seed, GreyImage& image) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const float value = kBlackLevel + kReadNoise * irwin_hall_normal(hash64(seed, i));
        image.pixels[i] = static_cast<std::uint8_t>(std::max(0.0F, std::round(value)));
    }
}

void overexpose(double gain, GreyImage& image) {
    std::array<std::uint8_t, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        table[i] = static_cast<std::uint8_t>(std::min(255.0, std::round(gain * static_cast<double>(i))));
    }
    for (std::uint8_t& pixel : image.pixels) {
        pixel = table[pixel];
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
