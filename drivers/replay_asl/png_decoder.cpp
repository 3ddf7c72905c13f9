// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/png_decoder.h"

#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>

#include "drivers/replay_asl/whole_file.h"

namespace facet {
namespace {

constexpr png_uint_32 kMaxSize = 16384;
constexpr png_fixed_point kRedWeight = 29900;  // of 100000, ITU-R BT.601
constexpr png_fixed_point kGreenWeight = 58700;
constexpr std::size_t kMessageLength = 128;

/// What libpng reads from, and where it stores its message.
struct PngBytes {
    const std::uint8_t* data = nullptr;
    std::size_t size = 0;
    std::size_t position = 0;
    char message[kMessageLength] = "";
};

void read_bytes(png_structp png, png_bytep out, std::size_t count) {
    auto* source = static_cast<PngBytes*>(png_get_io_ptr(png));
    if (count > source->size - source->position) {
        png_error(png, "file ends too early");
    }
    std::memcpy(out, source->data + source->position, count);
    source->position += count;
}

void keep_error(png_structp png, png_const_charp message) {
    auto* source = static_cast<PngBytes*>(png_get_error_ptr(png));
    std::snprintf(source->message, kMessageLength, "%s", message);
    png_longjmp(png, 1);
}

void ignore_warning(png_structp /*png*/, png_const_charp /*message*/) {}

/// Reads the header and sets the conversions to 8-bit grey. No object here may have a destructor: libpng jumps out.
bool read_header(png_structp png, png_infop info, png_uint_32& width, png_uint_32& height, std::size_t& row_bytes) {
    if (setjmp(png_jmpbuf(png)) != 0) {
        return false;
    }
    png_set_user_limits(png, kMaxSize, kMaxSize);
    png_read_info(png, info);
    const png_byte colour = png_get_color_type(png, info);
    png_set_scale_16(png);
    png_set_expand(png);  // palette to RGB, fewer than 8 bits to 8
    png_set_strip_alpha(png);
    if ((colour & PNG_COLOR_MASK_COLOR) != 0) {
        png_set_rgb_to_gray_fixed(png, PNG_ERROR_ACTION_NONE, kRedWeight, kGreenWeight);
    }
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    width = png_get_image_width(png, info);
    height = png_get_image_height(png, info);
    row_bytes = png_get_rowbytes(png, info);
    return true;
}

/// Reads all pixels and the rest of the file. No destructors here either.
bool read_pixels(png_structp png, png_bytepp rows) {
    if (setjmp(png_jmpbuf(png)) != 0) {
        return false;
    }
    png_read_image(png, rows);
    png_read_end(png, nullptr);
    return true;
}

void* allocate(png_structp png, png_alloc_size_t size) {
    return static_cast<PngArena*>(png_get_mem_ptr(png))->allocate(size);
}

void give_back(png_structp png, png_voidp piece) { static_cast<PngArena*>(png_get_mem_ptr(png))->free(piece); }

/// Owns libpng's two structures.
struct PngReader {
    PngReader(PngBytes& source, PngArena& arena)
        : png(png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &source, keep_error, ignore_warning, &arena, allocate,
                                       give_back)) {
        if (png != nullptr) {
            info = png_create_info_struct(png);
            png_set_read_fn(png, &source, read_bytes);
        }
    }
    ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;

    png_structp png = nullptr;
    png_infop info = nullptr;
};

}  // namespace

Status PngDecoder::decode(const std::string& path, int expected_width, int expected_height, GreyImage& image) {
    std::size_t size = 0;
    if (!read_whole_file(path, kMostBytes, file_, size, error_)) {
        return Status::kNotFound;
    }
    return decode(std::span(file_).first(size), expected_width, expected_height, image);
}

Status PngDecoder::decode(std::span<const std::uint8_t> png, int expected_width, int expected_height,
                          GreyImage& image) {
    arena_.reset();
    PngBytes source{.data = png.data(), .size = png.size()};
    PngReader reader(source, arena_);
    if (reader.png == nullptr || reader.info == nullptr) {
        error_ = "libpng cannot be initialised";
        return Status::kCorrupt;
    }
    png_uint_32 width = 0;
    png_uint_32 height = 0;
    std::size_t row_bytes = 0;
    if (!read_header(reader.png, reader.info, width, height, row_bytes)) {
        error_ = source.message;
        return Status::kCorrupt;
    }
    if (row_bytes != width) {
        error_ = "cannot be converted to 8-bit grey";
        return Status::kCorrupt;
    }
    if ((expected_width > 0 && static_cast<int>(width) != expected_width) ||
        (expected_height > 0 && static_cast<int>(height) != expected_height)) {
        error_ = "size is " + std::to_string(width) + "x" + std::to_string(height) + ", not " +
                 std::to_string(expected_width) + "x" + std::to_string(expected_height);
        image.width = static_cast<int>(width);
        image.height = static_cast<int>(height);
        image.pixels.clear();
        return Status::kInvalidArgument;
    }
    image.width = static_cast<int>(width);
    image.height = static_cast<int>(height);
    image.pixels.resize(static_cast<std::size_t>(width) * height);
    rows_.resize(height);
    for (std::size_t v = 0; v < height; ++v) {
        rows_[v] = image.pixels.data() + v * width;
    }
    if (!read_pixels(reader.png, rows_.data())) {
        error_ = source.message;
        return Status::kCorrupt;
    }
    return Status::kOk;
}

}  // namespace facet
