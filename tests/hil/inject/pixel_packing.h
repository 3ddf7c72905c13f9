// SPDX-License-Identifier: BSD-2-Clause
// 8-bit images as cameras with other formats would send them: the far side of drivers/camera_v4l2/unpack.h.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/camera_v4l2/unpack.h"

namespace facet::hil {

struct PixelLayout {
    PixelFormat format = PixelFormat::kGrey;
    int significant_bits = 0;  ///< as in RawImage
    bool msb_aligned = false;  ///< as in RawImage
};

/// The pixels as the upper 8 of the format's bits; the lower ones are what the pixel has there, so that they are not
/// zero, and chroma is not grey. @param grey  rows without padding, of a width that is a multiple of 4
std::vector<std::uint8_t> pack(const PixelLayout& layout, std::span<const std::uint8_t> grey);

}  // namespace facet::hil
