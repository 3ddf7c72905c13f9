// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/jpeg_decoder.h"

#include <jpeglib.h>
#include <cstdio>  // jpeglib.h needs it before it

#include <csetjmp>

namespace facet {
namespace {

struct JpegErrors {
    jpeg_error_mgr manager;
    std::jmp_buf jump;
    char message[JMSG_LENGTH_MAX];
};

void keep_error(j_common_ptr info) {
    auto* const errors = reinterpret_cast<JpegErrors*>(info->err);
    info->err->format_message(info, errors->message);
    std::longjmp(errors->jump, 1);
}

/// A warning says that data are damaged or missing, which libjpeg replaces by grey.
void count_warning(j_common_ptr info, int level) { info->err->num_warnings += level < 0 ? 1 : 0; }

/// Both steps of a decoder. No object here may have a destructor: libjpeg jumps out.
bool begin_jpeg(jpeg_decompress_struct& info, JpegErrors& errors, std::span<const std::uint8_t> bytes) {
    if (setjmp(errors.jump) != 0) {
        return false;
    }
    jpeg_create_decompress(&info);
    jpeg_mem_src(&info, bytes.data(), bytes.size());
    jpeg_read_header(&info, TRUE);
    info.out_color_space = JCS_GRAYSCALE;
    return true;
}

bool finish_jpeg(jpeg_decompress_struct& info, JpegErrors& errors, std::uint8_t* pixels) {
    if (setjmp(errors.jump) != 0) {
        return false;
    }
    jpeg_start_decompress(&info);
    while (info.output_scanline < info.output_height) {
        JSAMPROW row = pixels + std::size_t{info.output_scanline} * info.output_width;
        jpeg_read_scanlines(&info, &row, 1);
    }
    jpeg_finish_decompress(&info);
    return true;
}

}  // namespace

Status read_jpeg(std::span<const std::uint8_t> bytes, const WantedSize& wanted, GreyImage& grey, std::string& error) {
    JpegErrors errors{};
    jpeg_decompress_struct info{};
    info.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = keep_error;
    errors.manager.emit_message = count_warning;
    bool is_read = begin_jpeg(info, errors, bytes);
    Status status = Status::kCorrupt;
    error.clear();
    if (is_read) {
        status = take_size(info.image_width, info.image_height, wanted, grey, error);
        is_read = !ok(status) || finish_jpeg(info, errors, grey.pixels.data());
    }
    jpeg_destroy_decompress(&info);
    if (!is_read) {
        error = std::string("damaged JPEG: ") + errors.message;
    } else if (ok(status) && errors.manager.num_warnings > 0) {
        error = "damaged JPEG: data are missing or wrong";
    }
    return is_read && !ok(status) ? status : error.empty() ? Status::kOk : Status::kCorrupt;
}

}  // namespace facet
