// SPDX-License-Identifier: BSD-2-Clause
// A non-owning view of an 8-bit grey image.
#pragma once

#include <cstddef>
#include <cstdint>

namespace facet {

/// Rows of 8-bit grey pixels that someone else owns; row r starts at data + r * stride. Pixel (u, v) = (column, row),
/// the centre of the top left pixel is (0, 0). Valid only while the owner keeps the buffer. Reentrant. No heap.
struct ImageView {
    const std::uint8_t* data = nullptr;
    int width = 0;              ///< columns (px)
    int height = 0;             ///< rows (px)
    std::ptrdiff_t stride = 0;  ///< bytes from one row to the next, >= width

    constexpr bool empty() const { return data == nullptr || width <= 0 || height <= 0; }
    constexpr const std::uint8_t* row(int v) const { return data + static_cast<std::ptrdiff_t>(v) * stride; }
    constexpr std::uint8_t at(int u, int v) const { return row(v)[u]; }
};

}  // namespace facet
