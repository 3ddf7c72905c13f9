// SPDX-License-Identifier: BSD-2-Clause
// Copies of 8-bit grey images without the padding of their rows.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "platform/base/image_view.h"

namespace facet {

/// Copies width * height pixels to `pixels`. @return the copy, valid as long as they are; empty if the image is.
/// Reentrant. No heap.
inline ImageView copy_pixels(const ImageView& image, std::uint8_t* pixels) {
    if (image.empty()) {
        return {};
    }
    for (int v = 0; v < image.height; ++v) {
        std::copy_n(image.row(v), image.width, pixels + static_cast<std::ptrdiff_t>(v) * image.width);
    }
    return {pixels, image.width, image.height, image.width};
}

/// The same into `room`. @return empty as well if the image has more pixels than that
inline ImageView copy_if_it_fits(const ImageView& image, std::span<std::uint8_t> room) {
    const bool fits =
        image.empty() || static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) <= room.size();
    return fits ? copy_pixels(image, room.data()) : ImageView{};
}

}  // namespace facet
