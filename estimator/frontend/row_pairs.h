// SPDX-License-Identifier: BSD-2-Clause
// A grey image in which every pixel also holds the one below it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace facet {

/// Pixel (u, v) at data[v * stride + u]: its own grey value in the low byte, that of (u, v + 1) in the high one (in the
/// last row, its own again). So the four pixels that a bilinear interpolation needs are four consecutive bytes on a
/// little-endian machine. Valid only while the owner keeps the buffer. Reentrant. No heap.
struct RowPairs {
    const std::uint16_t* data = nullptr;
    int width = 0;              ///< columns (px)
    int height = 0;             ///< rows (px)
    std::ptrdiff_t stride = 0;  ///< pixels from one row to the next
};

}  // namespace facet
