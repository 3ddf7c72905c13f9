// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/unpack.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>
#include <vector>

namespace facet::unpack_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes unpacked(const RawImage& image) {
    Bytes out(static_cast<std::size_t>(image.width * image.height), 0xEE);
    REQUIRE(unpack(image, out) == Status::kOk);
    return out;
}

TEST_CASE("each format, worked by hand") {
    const Bytes grey{1, 2, 3, 99, 4, 5, 6};
    CHECK(unpacked({grey, PixelFormat::kGrey, 3, 2, 4, 0}) == Bytes{1, 2, 3, 4, 5, 6});
    // 0x3FF, 0x004, 0x003, 0x400 (above ten bits: saturates)
    const Bytes words{0xFF, 0x03, 0x04, 0x00, 0x03, 0x00, 0x00, 0x04};
    CHECK(unpacked({words, PixelFormat::kY10, 4, 1, 8, 0}) == Bytes{255, 1, 0, 255});
    CHECK(unpacked({words, PixelFormat::kY12, 4, 1, 8, 0}) == Bytes{63, 0, 0, 64});
    CHECK(unpacked({words, PixelFormat::kY16, 4, 1, 8, 0}) == Bytes{3, 0, 0, 4});
    CHECK(unpacked({words, PixelFormat::kY16, 4, 1, 8, 10}) == Bytes{255, 1, 0, 255});
    // The same bits, moved to the high end of their words: 0x3FF << 6, 0x004 << 6, 0x003 << 6, 0x200 << 6.
    const Bytes high{0xC0, 0xFF, 0x00, 0x01, 0xC0, 0x00, 0x00, 0x80};
    CHECK(unpacked({high, PixelFormat::kY10, 4, 1, 8, 0, true}) == Bytes{255, 1, 0, 128});
    CHECK(unpacked({high, PixelFormat::kY12, 4, 1, 8, 0, true}) == Bytes{255, 1, 0, 128});
    CHECK(unpacked({high, PixelFormat::kY16, 4, 1, 8, 10, true}) == Bytes{255, 1, 0, 128});
    CHECK(unpacked({high, PixelFormat::kY012, 4, 1, 8, 0}) == Bytes{255, 1, 0, 128});
    const Bytes packed{10, 20, 30, 40, 0xE4, 50, 60, 70, 80, 0xFF};
    CHECK(unpacked({packed, PixelFormat::kY10p, 8, 1, 10, 0}) == Bytes{10, 20, 30, 40, 50, 60, 70, 80});
    const Bytes yuyv{16, 128, 235, 127, 100, 1, 101, 2};
    CHECK(unpacked({yuyv, PixelFormat::kYuyv, 4, 1, 8, 0}) == Bytes{16, 235, 100, 101});
    CHECK(unpacked({yuyv, PixelFormat::kUyvy, 4, 1, 8, 0}) == Bytes{128, 127, 1, 2});
    // Two rows of luma, padded, then what is not looked at.
    const Bytes nv12{1, 2, 9, 3, 4, 9, 200, 201, 9};
    CHECK(unpacked({nv12, PixelFormat::kNv12, 2, 2, 3, 0}) == Bytes{1, 2, 3, 4});
    // Left and right of each pixel in turn; the image has both views, side by side.
    const Bytes both{1, 101, 2, 102, 99, 3, 103, 4, 104, 99};
    CHECK(unpacked({both, PixelFormat::kY8i, 4, 2, 5, 0}) == Bytes{1, 2, 101, 102, 3, 4, 103, 104});
    // Left 0xABC, right 0x123; left 0x00F, right 0xFF0.
    const Bytes packed_both{0xBC, 0x3A, 0x12, 0x0F, 0x00, 0xFF};
    CHECK(unpacked({packed_both, PixelFormat::kY12i, 4, 1, 6, 0}) == Bytes{0xAB, 0x00, 0x12, 0xFF});
}

/// Writes pixels of `bits` bits as a camera does.
Bytes pack(PixelFormat format, const std::vector<unsigned>& pixels, int width, int height, std::size_t stride,
           std::mt19937& random) {
    Bytes bytes(stride * static_cast<std::size_t>(height));
    for (std::uint8_t& padding : bytes) {
        padding = static_cast<std::uint8_t>(random());
    }
    for (int v = 0; v < height; ++v) {
        std::uint8_t* row = bytes.data() + static_cast<std::size_t>(v) * stride;
        if (format == PixelFormat::kY10p) {
            for (int u = 0; u < width; u += 4) {
                row[u / 4 * 5 + 4] = 0;
            }
        }
        for (int u = 0; u < width; ++u) {
            const unsigned value = pixels[static_cast<std::size_t>(v * width + u)];
            switch (format) {
                case PixelFormat::kGrey: row[u] = static_cast<std::uint8_t>(value); break;
                case PixelFormat::kYuyv: row[2 * u] = static_cast<std::uint8_t>(value); break;
                case PixelFormat::kY10p:
                    row[u / 4 * 5 + u % 4] = static_cast<std::uint8_t>(value >> 2);
                    row[u / 4 * 5 + 4] |= static_cast<std::uint8_t>((value & 3) << (2 * (u % 4)));
                    break;
                default:
                    row[2 * u] = static_cast<std::uint8_t>(value & 0xFF);
                    row[2 * u + 1] = static_cast<std::uint8_t>(value >> 8);
            }
        }
    }
    return bytes;
}

TEST_CASE("bit-exact against a model that packs, at odd strides and sizes") {
    struct Case {
        PixelFormat format;
        int bits;
    };
    std::mt19937 random(7);  // NOLINT(cert-msc51-cpp): fixed on purpose
    for (const auto& [format, bits] :
         {Case{PixelFormat::kGrey, 8}, Case{PixelFormat::kY10, 10}, Case{PixelFormat::kY10p, 10},
          Case{PixelFormat::kY12, 12}, Case{PixelFormat::kY16, 16}, Case{PixelFormat::kYuyv, 8}}) {
        for (int trial = 0; trial < 50; ++trial) {
            const int width = format == PixelFormat::kY10p ? 4 * static_cast<int>(1 + random() % 20)
                                                           : static_cast<int>(1 + random() % 80);
            const int height = static_cast<int>(1 + random() % 20);
            const std::size_t stride = row_bytes(format, width) + random() % 13;
            std::vector<unsigned> pixels(static_cast<std::size_t>(width * height));
            for (unsigned& pixel : pixels) {
                pixel = static_cast<unsigned>(random()) & ((1U << bits) - 1);
            }
            const Bytes bytes = pack(format, pixels, width, height, stride, random);
            const Bytes out = unpacked({bytes, format, width, height, stride, 0});
            bool same = true;
            for (std::size_t i = 0; i < pixels.size(); ++i) {
                same = same && out[i] == pixels[i] >> (bits - 8);
            }
            REQUIRE(same);
        }
    }
}

TEST_CASE("images that do not fit are refused, and nothing is written") {
    const Bytes bytes(100);
    Bytes out(100, 7);
    CHECK(unpack({bytes, PixelFormat::kGrey, 0, 5, 10, 0}, out) == Status::kInvalidArgument);
    CHECK(unpack({bytes, PixelFormat::kGrey, 11, 5, 10, 0}, out) == Status::kInvalidArgument);
    CHECK(unpack({bytes, PixelFormat::kY10, 10, 5, 19, 0}, out) == Status::kInvalidArgument);
    CHECK(unpack({bytes, PixelFormat::kY10p, 6, 1, 10, 0}, out) == Status::kInvalidArgument);
    CHECK(unpack({bytes, PixelFormat::kY16, 4, 1, 10, 7}, out) == Status::kInvalidArgument);
    CHECK(unpack({bytes, PixelFormat::kGrey, 10, 10, 10, 0}, std::span(out).first(99)) == Status::kInvalidArgument);
    Bytes large(200);
    CHECK(unpack({bytes, PixelFormat::kGrey, 10, 11, 10, 0}, large) == Status::kCorrupt);
    CHECK(unpack({bytes, PixelFormat::kGrey, 9, 11, 9, 0}, out) == Status::kOk);  // 99 bytes, last row not padded
    CHECK(out[99] == 7);
}

TEST_CASE("formats by name and code") {
    for (const std::string_view code :
         {"GREY", "Y10 ", "Y10P", "Y12 ", "Y16 ", "YUYV", "UYVY", "NV12", "Y8I ", "Y12I", "MJPG"}) {
        const auto format = pixel_format(code);
        REQUIRE(format);
        CHECK(pixel_format(code.substr(0, code.find(' '))) == format);
        // The first letter is the lowest byte.
        std::uint32_t letters = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            letters |= static_cast<std::uint32_t>(code[i]) << (8 * i);
        }
        CHECK(fourcc(*format) == letters);
    }
    CHECK(pixel_format("Y10 ") == PixelFormat::kY10);
    CHECK_FALSE(pixel_format("H264"));
    CHECK(fourcc(PixelFormat::kGrey) == 0x59455247);
}

}  // namespace
}  // namespace facet::unpack_test
