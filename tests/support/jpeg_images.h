// SPDX-License-Identifier: BSD-2-Clause
// JPEGs as cameras make them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/support/jpeg_writer.h"

namespace facet::test {

struct Jpeg {
    bool is_grey = false;
    int h = 1;  ///< sampling of luma against chroma
    int v = 1;
    bool has_tables = true;  ///< of Huffman: UVC cameras leave out those that are the usual ones
    bool is_progressive = false;
    int restart_rows = 0;  ///< rows of blocks between two restart markers; 0: none
};

/// A picture with gradients and edges.
inline int luma_at(int u, int v) { return (u / 16 + v / 12) % 2 == 0 ? 60 + u % 128 : 200 - v % 64; }

/// Without its Huffman tables (marker 0xFFC4) before the scan.
inline std::vector<std::uint8_t> without_tables(const std::vector<std::uint8_t>& bytes) {
    std::vector<std::uint8_t> left(bytes.begin(), bytes.begin() + 2);
    std::size_t at = 2;
    while (bytes[at + 1] != 0xDA) {
        const std::size_t size = 2 + bytes[at + 2] * std::size_t{256} + bytes[at + 3];
        if (bytes[at + 1] != 0xC4) {
            left.insert(left.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
                        bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
        }
        at += size;
    }
    left.insert(left.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end());
    return left;
}

inline std::vector<std::uint8_t> jpeg_of(int width, int height, const Jpeg& kind, int brighter = 0) {
    const auto tune = [&kind](jpeg_compress_struct& info) {
        jpeg_set_quality(&info, 85, TRUE);
        info.comp_info[0].h_samp_factor = kind.h;
        info.comp_info[0].v_samp_factor = kind.v;
        info.restart_in_rows = kind.restart_rows;
        if (kind.is_progressive) {
            jpeg_simple_progression(&info);
        }
    };
    const auto row = [&](int v) {
        std::vector<std::uint8_t> samples;
        for (int u = 0; u < width; ++u) {
            samples.push_back(static_cast<std::uint8_t>(luma_at(u, v) + brighter));
            if (!kind.is_grey) {
                samples.push_back(static_cast<std::uint8_t>(90 + u % 100));
                samples.push_back(140);
            }
        }
        return samples;
    };
    const std::vector<std::uint8_t> bytes =
        write_jpeg(width, height, kind.is_grey ? JCS_GRAYSCALE : JCS_YCbCr, tune, row);
    return kind.has_tables ? bytes : without_tables(bytes);
}

}  // namespace facet::test
