// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/grey_image.h"

#include <jpeglib.h>
#include <cstdio>  // jpeglib.h needs it before it

#include <algorithm>
#include <csetjmp>

namespace facet {
namespace {

constexpr std::uint32_t kMostPixelsAside = 16384;  // as PngDecoder

std::uint8_t luma(unsigned r, unsigned g, unsigned b) {
    return static_cast<std::uint8_t>((299 * r + 587 * g + 114 * b + 500) / 1000);
}

/// Where the red samples are in each square of two by two pixels, blue ones being diagonal to them.
struct Bayer {
    std::string_view name;
    unsigned red_u;
    unsigned red_v;
};
constexpr Bayer kBayers[] = {
    {"bayer_rggb8", 0, 0}, {"bayer_bggr8", 1, 1}, {"bayer_gbrg8", 0, 1}, {"bayer_grbg8", 1, 0}};

struct Layout {
    std::string_view name;
    unsigned bytes;        ///< a pixel
    unsigned red;          ///< place of the red sample; green is in the middle
    bool is_wide = false;  ///< one sample of 16 bits
};
constexpr Layout kLayouts[] = {{"mono8", 1, 0}, {"8UC1", 1, 0}, {"mono16", 2, 0, true}, {"16UC1", 2, 0, true},
                               {"rgb8", 3, 0},  {"bgr8", 3, 2}, {"8UC3", 3, 2},         {"rgba8", 4, 0},
                               {"bgra8", 4, 2}, {"8UC4", 4, 2}};

std::uint8_t grey_pixel(const std::uint8_t* pixel, const Layout& layout, bool is_big_endian) {
    if (layout.is_wide) {
        const unsigned value = is_big_endian ? pixel[0] << 8U | pixel[1] : pixel[1] << 8U | pixel[0];
        return static_cast<std::uint8_t>((value * 255U + 32895U) >> 16U);  // as libpng scales
    }
    return layout.bytes == 1 ? pixel[0] : luma(pixel[layout.red], pixel[1], pixel[2 - layout.red]);
}

std::uint8_t bayer_pixel(const RosImage& image, const Bayer& bayer, unsigned u, unsigned v) {
    std::array<unsigned, 3> sum{};
    std::array<unsigned, 3> count{};
    for (unsigned y = v == 0 ? 0 : v - 1; y <= std::min(v + 1, image.height - 1); ++y) {
        for (unsigned x = u == 0 ? 0 : u - 1; x <= std::min(u + 1, image.width - 1); ++x) {
            const unsigned colour = (x + bayer.red_u) % 2 + (y + bayer.red_v) % 2;  // red 0, green 1, blue 2
            const std::size_t at = static_cast<std::size_t>(y) * image.step + x;
            sum[colour] += image.data[at];
            ++count[colour];
        }
    }
    const auto mean = [&](std::size_t colour) {
        return count[colour] == 0 ? 0U : (sum[colour] + count[colour] / 2) / count[colour];
    };
    return luma(mean(0), mean(1), mean(2));
}

/// @return why an image of so many bytes a pixel cannot be read; empty if it can
std::string size_problem(const RosImage& image, unsigned bytes_a_pixel) {
    if (image.width == 0 || image.height == 0 || image.width > kMostPixelsAside || image.height > kMostPixelsAside) {
        return "has no pixels, or more than 16384 on a side";
    }
    const std::size_t row = std::size_t{image.width} * bytes_a_pixel;
    if (image.step < row || image.data.size() < std::size_t{image.step} * (image.height - 1) + row) {
        return "has fewer bytes than its size needs";
    }
    return "";
}

void resize(GreyImage& grey, std::uint32_t width, std::uint32_t height) {
    grey.width = static_cast<int>(width);
    grey.height = static_cast<int>(height);
    grey.pixels.resize(std::size_t{width} * height);
}

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

std::string to_grey(const RosImage& image, GreyImage& grey) {
    const auto* const bayer = std::ranges::find(kBayers, image.encoding, &Bayer::name);
    const auto* const layout = std::ranges::find(kLayouts, image.encoding, &Layout::name);
    const bool is_bayer = bayer != std::end(kBayers);
    if (!is_bayer && layout == std::end(kLayouts)) {
        return "has the unknown encoding '" + std::string(image.encoding.substr(0, 40)) + "'";
    }
    const unsigned bytes = is_bayer ? 1 : layout->bytes;
    if (std::string problem = size_problem(image, bytes); !problem.empty()) {
        return problem;
    }
    resize(grey, image.width, image.height);
    std::uint8_t* to = grey.pixels.data();
    for (unsigned v = 0; v < image.height; ++v) {
        const std::uint8_t* const row = image.data.data() + std::size_t{v} * image.step;
        for (unsigned u = 0; u < image.width; ++u) {
            *to++ = is_bayer ? bayer_pixel(image, *bayer, u, v)
                             : grey_pixel(row + std::size_t{u} * bytes, *layout, image.is_big_endian);
        }
    }
    return "";
}

std::string read_jpeg(std::span<const std::uint8_t> bytes, GreyImage& grey) {
    JpegErrors errors{};
    jpeg_decompress_struct info{};
    info.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = keep_error;
    errors.manager.emit_message = count_warning;
    bool is_read = begin_jpeg(info, errors, bytes);
    std::string problem;
    if (is_read && (info.image_width > kMostPixelsAside || info.image_height > kMostPixelsAside)) {
        problem = "has more than 16384 pixels on a side";
    } else if (is_read) {
        resize(grey, info.image_width, info.image_height);
        is_read = finish_jpeg(info, errors, grey.pixels.data());
    }
    jpeg_destroy_decompress(&info);
    if (is_read && problem.empty() && errors.manager.num_warnings > 0) {
        problem = "damaged JPEG: data are missing or wrong";
    }
    return is_read ? problem : std::string("damaged JPEG: ") + errors.message;
}

}  // namespace facet
