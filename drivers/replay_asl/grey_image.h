// SPDX-License-Identifier: BSD-2-Clause
// 8-bit grey images in memory, and how colours and deeper samples become them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "platform/base/image_view.h"
#include "platform/base/status.h"

namespace facet {

/// An image that owns its pixels, rows without padding.
struct GreyImage {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> pixels;

    ImageView view() const { return {.data = pixels.data(), .width = width, .height = height, .stride = width}; }
    /// Storage is reused.
    void resize(int new_width, int new_height) {
        width = new_width;
        height = new_height;
        pixels.resize(static_cast<std::size_t>(new_width) * static_cast<std::size_t>(new_height));
    }
};

inline constexpr unsigned kMostPixelsAside = 16384;  ///< that a decoder takes

/// What an image must have (px); zero for any.
struct WantedSize {
    int width = 0;
    int height = 0;
};

/// Makes room for an image of the size that a header states, before anything of it is decoded.
/// @return kCorrupt if a side is longer than kMostPixelsAside; kInvalidArgument if it is not as requested (grey then
///         has the size found and no pixels). `error` says so.
inline Status take_size(unsigned width, unsigned height, const WantedSize& wanted, GreyImage& grey,
                        std::string& error) {
    if (width > kMostPixelsAside || height > kMostPixelsAside) {
        error = "has more than 16384 pixels on a side";
        return Status::kCorrupt;
    }
    const auto is_other = [](int want, unsigned found) { return want > 0 && found != static_cast<unsigned>(want); };
    if (is_other(wanted.width, width) || is_other(wanted.height, height)) {
        error = "size is " + std::to_string(width) + "x" + std::to_string(height) + ", not " +
                std::to_string(wanted.width) + "x" + std::to_string(wanted.height);
        grey.width = static_cast<int>(width);
        grey.height = static_cast<int>(height);
        grey.pixels.clear();
        return Status::kInvalidArgument;
    }
    grey.resize(static_cast<int>(width), static_cast<int>(height));
    return Status::kOk;
}

/// Luma 0.299 R + 0.587 G + 0.114 B of stored values (ITU-R BT.601), without gamma.
constexpr std::uint8_t luma(unsigned r, unsigned g, unsigned b) {
    return static_cast<std::uint8_t>((299 * r + 587 * g + 114 * b + 500) / 1000);
}

/// A sample of up to `most` as 8 bits, rounded; of 16 bits as libpng does.
constexpr std::uint8_t scaled_to_8_bits(unsigned value, unsigned most) {
    if (most == 0xFFFFU) {
        return static_cast<std::uint8_t>((value * 255U + 32895U) >> 16U);
    }
    return static_cast<std::uint8_t>(((value < most ? value : most) * 255U + most / 2U) / most);
}

}  // namespace facet
