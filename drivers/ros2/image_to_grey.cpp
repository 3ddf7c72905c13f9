// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/image_to_grey.h"

#include <algorithm>
#include <cstdio>

namespace facet {
namespace {

/// How the grey value of a pixel is found in its bytes.
enum class Pixel : std::uint8_t { kByte, kWide, kColour, kMosaic };

struct Encoding {
    std::string_view name;
    std::size_t bytes;  ///< of a pixel
    Pixel pixel;
    std::size_t first;  ///< byte of grey, or of red
    std::size_t blue;
};

constexpr std::array kEncodings{
    Encoding{"mono8", 1, Pixel::kByte, 0, 0},         Encoding{"8UC1", 1, Pixel::kByte, 0, 0},
    Encoding{"mono16", 2, Pixel::kWide, 0, 0},        Encoding{"rgb8", 3, Pixel::kColour, 0, 2},
    Encoding{"bgr8", 3, Pixel::kColour, 2, 0},        Encoding{"8UC3", 3, Pixel::kColour, 2, 0},
    Encoding{"rgba8", 4, Pixel::kColour, 0, 2},       Encoding{"bgra8", 4, Pixel::kColour, 2, 0},
    Encoding{"yuv422", 2, Pixel::kByte, 1, 0},        Encoding{"yuv422_yuy2", 2, Pixel::kByte, 0, 0},
    Encoding{"bayer_rggb8", 1, Pixel::kMosaic, 0, 0}, Encoding{"bayer_bggr8", 1, Pixel::kMosaic, 0, 0},
    Encoding{"bayer_gbrg8", 1, Pixel::kMosaic, 0, 0}, Encoding{"bayer_grbg8", 1, Pixel::kMosaic, 0, 0},
};

constexpr int kShownOfName = 24;

/// The beginning of a name that somebody else has chosen.
std::array<char, kShownOfName + 1> shown(std::string_view name) {
    std::array<char, kShownOfName + 1> text{};
    for (std::size_t i = 0; i < std::min<std::size_t>(name.size(), kShownOfName); ++i) {
        text[i] = name[i] >= ' ' && name[i] <= '~' ? name[i] : '?';
    }
    return text;
}

template <class... Args>
Status refuse_image(ImageFault& fault, const char* format, Args... args) {
    std::snprintf(fault.data(), fault.size(), format, args...);
    return Status::kCorrupt;
}

/// Beyond a border, the same number of pixels within: the colours of a mosaic stay in their order.
std::size_t mirrored(std::size_t at, int step, std::size_t size) {
    if (size < 2) {
        return at;
    }
    const bool is_beyond = step < 0 ? at == 0 : at + 1 == size;
    return is_beyond == (step < 0) ? at + 1 : at - 1;
}

void mosaic_row_to_grey(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below,
                        std::size_t width, std::uint8_t* to) {
    const auto column = [&](std::size_t u) { return above[u] + 2U * row[u] + below[u]; };
    for (std::size_t u = 0; u < width; ++u) {
        const unsigned sum = column(mirrored(u, -1, width)) + 2U * column(u) + column(mirrored(u, 1, width));
        to[u] = static_cast<std::uint8_t>((sum + 8U) >> 4U);
    }
}

void row_to_grey(const Encoding& encoding, bool is_bigendian, const std::uint8_t* from, std::size_t width,
                 std::uint8_t* to) {
    switch (encoding.pixel) {
        case Pixel::kMosaic: break;  // needs the rows beside it
        case Pixel::kByte:
            for (std::size_t u = 0; u < width; ++u) {
                to[u] = from[u * encoding.bytes + encoding.first];
            }
            break;
        case Pixel::kWide:
            for (std::size_t u = 0; u < width; ++u) {
                to[u] = from[2 * u + (is_bigendian ? 0 : 1)];
            }
            break;
        case Pixel::kColour:
            for (std::size_t u = 0; u < width; ++u) {
                const std::uint8_t* const p = from + u * encoding.bytes;
                to[u] = static_cast<std::uint8_t>(
                    (77U * p[encoding.first] + 150U * p[1] + 29U * p[encoding.blue] + 128U) >> 8U);
            }
            break;
    }
}

}  // namespace

Status to_grey(const Ros2Image& image, int width, int height, std::span<std::uint8_t> out, ImageFault& fault) {
    if (width <= 0 || height <= 0 || out.size() < static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
        return Status::kInvalidArgument;
    }
    const auto* const encoding = std::ranges::find(kEncodings, image.encoding, &Encoding::name);
    if (encoding == kEncodings.end()) {
        return refuse_image(
            fault,
            "images are encoded as '%s', which is not used: mono8, mono16, 8UC1, rgb8, bgr8, bayer_..8 and "
            "their like are",
            shown(image.encoding).data());
    }
    if (image.width != static_cast<std::uint32_t>(width) || image.height != static_cast<std::uint32_t>(height)) {
        return refuse_image(fault, "images are %ux%u, the calibration is of %dx%d", image.width, image.height, width,
                            height);
    }
    const std::size_t row = encoding->bytes * image.width;
    const std::size_t needed = std::size_t{image.step} * (image.height - 1) + row;  // below 2^63
    if (image.step < row || image.data.size() < needed) {
        return refuse_image(fault, "images have %zu bytes in rows of %u, too few for %ux%u of %.24s", image.data.size(),
                            image.step, image.width, image.height, encoding->name.data());
    }
    const std::size_t rows = image.height;
    const auto row_at = [&](std::size_t v) { return image.data.data() + v * image.step; };
    for (std::size_t v = 0; v < rows; ++v) {
        std::uint8_t* const to = out.data() + v * image.width;
        if (encoding->pixel == Pixel::kMosaic) {
            mosaic_row_to_grey(row_at(mirrored(v, -1, rows)), row_at(v), row_at(mirrored(v, 1, rows)), image.width, to);
        } else {
            row_to_grey(*encoding, image.is_bigendian, row_at(v), image.width, to);
        }
    }
    return Status::kOk;
}

}  // namespace facet
