// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/grey_image.h"

#include <algorithm>

namespace facet {
namespace {

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
    unsigned red;          ///< place of the red sample; green is in the middle. Of a luma: its place
    bool is_wide = false;  ///< one sample of 16 bits
    bool is_luma = false;  ///< the sample is the luma, whatever stands beside it, or below the image
};
constexpr Layout kLayouts[] = {{"mono8", 1, 0},
                               {"8UC1", 1, 0},
                               {"mono16", 2, 0, true},
                               {"16UC1", 2, 0, true},
                               {"rgb8", 3, 0},
                               {"bgr8", 3, 2},
                               {"8UC3", 3, 2},
                               {"rgba8", 4, 0},
                               {"bgra8", 4, 2},
                               {"8UC4", 4, 2},
                               {"yuv422", 2, 1, false, true},
                               {"uyvy", 2, 1, false, true},
                               {"yuv422_yuy2", 2, 0, false, true},
                               {"yuyv", 2, 0, false, true},
                               {"nv21", 1, 0, false, true},
                               {"nv12", 1, 0, false, true},
                               {"nv24", 1, 0, false, true}};

const Layout* layout_of(std::string_view encoding) {
    const auto* const layout = std::ranges::find(kLayouts, encoding, &Layout::name);
    return layout == std::end(kLayouts) ? nullptr : layout;
}

unsigned wide_sample(const std::uint8_t* pixel, bool is_big_endian) {
    return is_big_endian ? pixel[0] << 8U | pixel[1] : pixel[1] << 8U | pixel[0];
}

std::uint8_t grey_pixel(const std::uint8_t* pixel, const Layout& layout, bool is_big_endian, unsigned most) {
    if (layout.is_wide) {
        return scaled_to_8_bits(wide_sample(pixel, is_big_endian), most);
    }
    if (layout.is_luma || layout.bytes == 1) {
        return pixel[layout.red];
    }
    return luma(pixel[layout.red], pixel[1], pixel[2 - layout.red]);
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

}  // namespace

std::string to_grey(const RosImage& image, unsigned bits, GreyImage& grey) {
    const auto* const bayer = std::ranges::find(kBayers, image.encoding, &Bayer::name);
    const Layout* const layout = layout_of(image.encoding);
    const bool is_bayer = bayer != std::end(kBayers);
    if (!is_bayer && layout == nullptr) {
        return "has the unknown encoding '" + std::string(image.encoding.substr(0, 40)) + "'";
    }
    const unsigned bytes = is_bayer ? 1 : layout->bytes;
    if (std::string problem = size_problem(image, bytes); !problem.empty()) {
        return problem;
    }
    const unsigned most = (1U << bits) - 1U;
    grey.resize(static_cast<int>(image.width), static_cast<int>(image.height));
    std::uint8_t* to = grey.pixels.data();
    for (unsigned v = 0; v < image.height; ++v) {
        const std::uint8_t* const row = image.data.data() + std::size_t{v} * image.step;
        for (unsigned u = 0; u < image.width; ++u) {
            *to++ = is_bayer ? bayer_pixel(image, *bayer, u, v)
                             : grey_pixel(row + std::size_t{u} * bytes, *layout, image.is_big_endian, most);
        }
    }
    return "";
}

unsigned greatest_wide_sample(const RosImage& image) {
    const Layout* const layout = layout_of(image.encoding);
    if (layout == nullptr || !layout->is_wide || !size_problem(image, layout->bytes).empty()) {
        return 0;
    }
    unsigned greatest = 0;
    for (unsigned v = 0; v < image.height; ++v) {
        const std::uint8_t* const row = image.data.data() + std::size_t{v} * image.step;
        for (unsigned u = 0; u < image.width; ++u) {
            greatest = std::max(greatest, wide_sample(row + std::size_t{2} * u, image.is_big_endian));
        }
    }
    return greatest;
}

}  // namespace facet
