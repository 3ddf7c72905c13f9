// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/unpack.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>

namespace facet {
namespace {

struct Named {
    PixelFormat format;
    std::uint32_t fourcc;
    std::string_view name;
};

constexpr std::array<Named, 12> kFormats{{{PixelFormat::kGrey, V4L2_PIX_FMT_GREY, "GREY"},
                                          {PixelFormat::kY10, V4L2_PIX_FMT_Y10, "Y10"},
                                          {PixelFormat::kY10p, V4L2_PIX_FMT_Y10P, "Y10P"},
                                          {PixelFormat::kY12, V4L2_PIX_FMT_Y12, "Y12"},
                                          {PixelFormat::kY012, v4l2_fourcc('Y', '0', '1', '2'), "Y012"},
                                          {PixelFormat::kY16, V4L2_PIX_FMT_Y16, "Y16"},
                                          {PixelFormat::kYuyv, V4L2_PIX_FMT_YUYV, "YUYV"},
                                          {PixelFormat::kUyvy, V4L2_PIX_FMT_UYVY, "UYVY"},
                                          {PixelFormat::kNv12, V4L2_PIX_FMT_NV12, "NV12"},
                                          {PixelFormat::kY8i, V4L2_PIX_FMT_Y8I, "Y8I"},
                                          {PixelFormat::kY12i, V4L2_PIX_FMT_Y12I, "Y12I"},
                                          {PixelFormat::kMjpg, V4L2_PIX_FMT_MJPEG, "MJPG"}}};

void unpack_words(const std::uint8_t* in, std::uint8_t* out, int width, int bits) {
    const int shift = bits - 8;
    for (int u = 0; u < width; ++u) {
        const unsigned word = static_cast<unsigned>(in[2 * u]) | (static_cast<unsigned>(in[2 * u + 1]) << 8);
        out[u] = static_cast<std::uint8_t>(std::min(word >> shift, 255U));
    }
}

void unpack_row(const RawImage& image, const std::uint8_t* in, std::uint8_t* out) {
    switch (image.format) {
        case PixelFormat::kGrey: std::copy_n(in, image.width, out); break;
        case PixelFormat::kY10: unpack_words(in, out, image.width, image.msb_aligned ? 16 : 10); break;
        case PixelFormat::kY12: unpack_words(in, out, image.width, image.msb_aligned ? 16 : 12); break;
        case PixelFormat::kY012: unpack_words(in, out, image.width, 16); break;
        case PixelFormat::kY16:
            unpack_words(in, out, image.width,
                         image.significant_bits == 0 || image.msb_aligned ? 16 : image.significant_bits);
            break;
        case PixelFormat::kY10p:
            for (int u = 0; u < image.width; u += 4) {
                std::copy_n(in + u / 4 * 5, 4, out + u);
            }
            break;
        case PixelFormat::kYuyv:
            for (int u = 0; u < image.width; ++u) {
                out[u] = in[2 * u];
            }
            break;
        case PixelFormat::kUyvy:
            for (int u = 0; u < image.width; ++u) {
                out[u] = in[2 * u + 1];
            }
            break;
        case PixelFormat::kNv12: std::copy_n(in, image.width, out); break;
        case PixelFormat::kY8i: {
            const int half = image.width / 2;
            for (int u = 0; u < half; ++u) {
                out[u] = in[2 * u];
                out[half + u] = in[2 * u + 1];
            }
            break;
        }
        case PixelFormat::kY12i: {
            // The upper 8 of the 12 bits: of the left view from two bytes, of the right one a byte of its own.
            const int half = image.width / 2;
            for (int u = 0; u < half; ++u) {
                const unsigned left = static_cast<unsigned>(in[3 * u]) | (static_cast<unsigned>(in[3 * u + 1]) << 8);
                out[u] = static_cast<std::uint8_t>((left & 0xFFFU) >> 4);
                out[half + u] = in[3 * u + 2];
            }
            break;
        }
        case PixelFormat::kMjpg: break;
    }
}

}  // namespace

std::uint32_t fourcc(PixelFormat format) { return kFormats[static_cast<std::size_t>(format)].fourcc; }

std::string_view to_string(PixelFormat format) { return kFormats[static_cast<std::size_t>(format)].name; }

std::optional<PixelFormat> pixel_format(std::string_view name) {
    while (name.ends_with(' ')) {
        name.remove_suffix(1);
    }
    for (const Named& known : kFormats) {
        if (known.name == name) {
            return known.format;
        }
    }
    return std::nullopt;
}

std::size_t row_bytes(PixelFormat format, int width) {
    const auto pixels = static_cast<std::size_t>(width);
    switch (format) {
        case PixelFormat::kGrey:
        case PixelFormat::kNv12:
        case PixelFormat::kY8i: return pixels;
        case PixelFormat::kY12i: return pixels / 2 * 3;
        case PixelFormat::kMjpg: return 1;
        case PixelFormat::kY10p: return pixels / 4 * 5;
        default: return 2 * pixels;
    }
}

Status unpack(const RawImage& image, std::span<std::uint8_t> out) {
    const bool shape_good =
        image.width > 0 && image.height > 0 && image.stride >= row_bytes(image.format, image.width) &&
        (image.format != PixelFormat::kY10p || image.width % 4 == 0) &&
        (!is_interleaved(image.format) || image.width % 2 == 0) && image.format != PixelFormat::kMjpg &&
        (image.significant_bits == 0 || (image.significant_bits >= 8 && image.significant_bits <= 16));
    const std::size_t pixels =
        shape_good ? static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) : 0;
    if (!shape_good || out.size() < pixels) {
        return Status::kInvalidArgument;
    }
    // The last row need not be padded.
    if (image.bytes.size() <
        image.stride * static_cast<std::size_t>(image.height - 1) + row_bytes(image.format, image.width)) {
        return Status::kCorrupt;
    }
    for (int v = 0; v < image.height; ++v) {
        unpack_row(image, image.bytes.data() + static_cast<std::size_t>(v) * image.stride,
                   out.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width));
    }
    return Status::kOk;
}

}  // namespace facet
