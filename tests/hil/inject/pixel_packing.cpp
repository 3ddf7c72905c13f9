// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/pixel_packing.h"

namespace facet::hil {
namespace {

int significant_bits(const PixelLayout& layout) {
    switch (layout.format) {
        case PixelFormat::kY10: return 10;
        case PixelFormat::kY12:
        case PixelFormat::kY012: return 12;
        default: return layout.significant_bits > 0 ? layout.significant_bits : 16;
    }
}

std::vector<std::uint8_t> pack_words(std::span<const std::uint8_t> grey, int bits, bool high) {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(2 * grey.size());
    for (const std::uint8_t pixel : grey) {
        const unsigned low = pixel & ((1U << (bits - 8)) - 1U);
        const unsigned word = ((static_cast<unsigned>(pixel) << (bits - 8)) | low) << (high ? 16 - bits : 0);
        bytes.push_back(static_cast<std::uint8_t>(word & 0xFFU));
        bytes.push_back(static_cast<std::uint8_t>(word >> 8));
    }
    return bytes;
}

}  // namespace

std::vector<std::uint8_t> pack(const PixelLayout& layout, std::span<const std::uint8_t> grey) {
    std::vector<std::uint8_t> bytes;
    switch (layout.format) {
        case PixelFormat::kGrey: bytes.assign(grey.begin(), grey.end()); break;
        case PixelFormat::kY10p:
            for (std::size_t i = 0; i < grey.size(); i += 4) {
                bytes.insert(bytes.end(), &grey[i], &grey[i] + 4);
                bytes.push_back(grey[i]);
            }
            break;
        case PixelFormat::kYuyv:
            for (const std::uint8_t pixel : grey) {
                bytes.push_back(pixel);
                bytes.push_back(static_cast<std::uint8_t>(~pixel));
            }
            break;
        default:
            return pack_words(grey, significant_bits(layout),
                              layout.msb_aligned || layout.format == PixelFormat::kY012);
    }
    return bytes;
}

}  // namespace facet::hil
