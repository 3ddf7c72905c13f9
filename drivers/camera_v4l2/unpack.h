// SPDX-License-Identifier: BSD-2-Clause
// Pixel formats of cameras to 8-bit grey.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "platform/base/status.h"

namespace facet {

/// Formats with a grey image, as in the kernel's documentation "Luma-Only Formats", "Packed YUV formats", "Planar YUV
/// formats" and "Compressed Formats".
enum class PixelFormat : std::uint8_t {
    kGrey,  ///< 8 bits
    kY10,   ///< 10 bits in the low bits of 16, little-endian
    kY10p,  ///< MIPI RAW10: four pixels' upper 8 bits, then a byte with their lower 2
    kY12,   ///< 12 bits in the low bits of 16, little-endian
    kY012,  ///< 12 bits in the high bits of 16, little-endian
    kY16,   ///< 16 bits, little-endian
    kYuyv,  ///< luma in every even byte
    kUyvy,  ///< luma in every odd byte
    kNv12,  ///< a plane of 8-bit luma, then one of chroma, which is not looked at
    kY8i,   ///< two views: a byte of the left one, a byte of the right one
    kY12i,  ///< two views: 12 bits of the left one, 12 of the right one, in 24 bits, little-endian
    kMjpg,  ///< each image a JPEG: MjpegDecoder
};

/// Each pixel is one of either view: the image that is made of it is twice as wide, left view first.
constexpr bool is_interleaved(PixelFormat format) {
    return format == PixelFormat::kY8i || format == PixelFormat::kY12i;
}

/// The kernel's four-character code.
std::uint32_t fourcc(PixelFormat format);
/// By name as in "GREY", "Y10 ", "Y10", "Y10P".
std::optional<PixelFormat> pixel_format(std::string_view name);

/// The name of the kernel's documentation. Valid as long as the program runs.
std::string_view to_string(PixelFormat format);

/// Bytes that a row of this many pixels fills, of both views where there are two; 1 for JPEG. Y10P rows need widths
/// that are multiples of 4, those of interleaved views multiples of 2.
std::size_t row_bytes(PixelFormat format, int width);

/// An image as a camera wrote it.
struct RawImage {
    std::span<const std::uint8_t> bytes;
    PixelFormat format = PixelFormat::kGrey;
    int width = 0;             ///< of both views where there are two (px)
    int height = 0;            ///< (px)
    std::size_t stride = 0;    ///< bytes from one row to the next
    int significant_bits = 0;  ///< of a Y16 that holds fewer in its low bits; 0 for all
    /// The significant bits of Y10, Y12 or Y16 are the high ones of the 16, as the bridges of i.MX 8 and Raspberry Pi 5
    /// write them, whatever the format's definition says.
    bool msb_aligned = false;
};

/// Keeps the upper 8 of the significant bits of every pixel (cut, not rounded: no pixel overflows, and neighbouring
/// formats of one sensor agree); bits above the significant ones saturate.
/// @param out  width * height bytes, rows without padding
/// @return kInvalidArgument if sizes do not fit each other or `out`, or for a JPEG; kCorrupt if bytes are missing.
///         Reentrant. No heap.
Status unpack(const RawImage& image, std::span<std::uint8_t> out);

}  // namespace facet
