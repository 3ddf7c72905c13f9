// SPDX-License-Identifier: BSD-2-Clause
// Copies of 8-bit grey images without the padding of their rows.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

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

}  // namespace facet
