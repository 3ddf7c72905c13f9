// SPDX-License-Identifier: BSD-2-Clause
// JPEGs as cameras make them.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <jpeglib.h>

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
    jpeg_compress_struct info{};
    jpeg_error_mgr errors{};
    info.err = jpeg_std_error(&errors);
    jpeg_create_compress(&info);
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&info, &bytes, &size);
    info.image_width = static_cast<JDIMENSION>(width);
    info.image_height = static_cast<JDIMENSION>(height);
    info.input_components = kind.is_grey ? 1 : 3;
    info.in_color_space = kind.is_grey ? JCS_GRAYSCALE : JCS_YCbCr;
    jpeg_set_defaults(&info);
    jpeg_set_quality(&info, 85, TRUE);
    info.comp_info[0].h_samp_factor = kind.h;
    info.comp_info[0].v_samp_factor = kind.v;
    info.restart_in_rows = kind.restart_rows;
    if (kind.is_progressive) {
        jpeg_simple_progression(&info);
    }
    jpeg_start_compress(&info, TRUE);
    std::vector<std::uint8_t> row;
    while (info.next_scanline < info.image_height) {
        row.clear();
        for (int u = 0; u < width; ++u) {
            row.push_back(static_cast<std::uint8_t>(luma_at(u, static_cast<int>(info.next_scanline)) + brighter));
            if (!kind.is_grey) {
                row.push_back(static_cast<std::uint8_t>(90 + u % 100));
                row.push_back(140);
            }
        }
        JSAMPROW rows = row.data();
        jpeg_write_scanlines(&info, &rows, 1);
    }
    jpeg_finish_compress(&info);
    std::vector<std::uint8_t> result(bytes, bytes + size);
    jpeg_destroy_compress(&info);
    std::free(bytes);
    return kind.has_tables ? result : without_tables(result);
}

}  // namespace facet::test
