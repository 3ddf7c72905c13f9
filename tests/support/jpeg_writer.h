// SPDX-License-Identifier: BSD-2-Clause
// JPEGs in memory, by libjpeg.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <jpeglib.h>

namespace facet::test {

/// @param space  of the rows: JCS_GRAYSCALE has one sample a pixel, others here three
/// @param tune   tune(jpeg_compress_struct&), after the defaults
/// @param row    row(v): samples of a row, as a vector
template <class Tune, class Row>
std::vector<std::uint8_t> write_jpeg(int width, int height, J_COLOR_SPACE space, Tune tune, Row row) {
    jpeg_compress_struct info{};
    jpeg_error_mgr errors{};
    info.err = jpeg_std_error(&errors);
    jpeg_create_compress(&info);
    unsigned char* memory = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&info, &memory, &size);
    info.image_width = static_cast<JDIMENSION>(width);
    info.image_height = static_cast<JDIMENSION>(height);
    info.input_components = space == JCS_GRAYSCALE ? 1 : 3;
    info.in_color_space = space;
    jpeg_set_defaults(&info);
    tune(info);
    jpeg_start_compress(&info, TRUE);
    for (int v = 0; v < height; ++v) {
        std::vector<std::uint8_t> samples = row(v);
        JSAMPROW rows = samples.data();
        jpeg_write_scanlines(&info, &rows, 1);
    }
    jpeg_finish_compress(&info);
    std::vector<std::uint8_t> bytes(memory, memory + size);
    jpeg_destroy_compress(&info);
    std::free(memory);
    return bytes;
}

}  // namespace facet::test
