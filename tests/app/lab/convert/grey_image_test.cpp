// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/grey_image.h"

#include <catch2/catch.hpp>
#include <cstdlib>

#include "drivers/replay_asl/jpeg_decoder.h"
#include "tests/support/asl_folder.h"

namespace facet::grey_image_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

RosImage image_of(std::string_view encoding, std::uint32_t width, std::uint32_t height, std::uint32_t step,
                  const Bytes& bytes) {
    RosImage image;
    image.encoding = encoding;
    image.width = width;
    image.height = height;
    image.step = step;
    image.data = bytes;
    return image;
}

Bytes grey_of(const RosImage& image) {
    GreyImage grey;
    REQUIRE(to_grey(image, 16, grey).empty());
    return grey.pixels;
}

}  // namespace

TEST_CASE("grey images lose their padding") {
    const Bytes bytes{1, 2, 99, 3, 4, 99};
    CHECK(grey_of(image_of("mono8", 2, 2, 3, bytes)) == Bytes{1, 2, 3, 4});
    CHECK(grey_of(image_of("8UC1", 2, 2, 3, bytes)) == Bytes{1, 2, 3, 4});
}

TEST_CASE("sixteen bits are rounded to eight in either order of bytes") {
    const Bytes bytes{0x00, 0x00, 0xFF, 0xFF, 0x80, 0x00, 0x00, 0x80};
    CHECK(grey_of(image_of("mono16", 4, 1, 8, bytes)) == Bytes{0, 255, 0, 128});
    RosImage big = image_of("mono16", 4, 1, 8, bytes);
    big.is_big_endian = true;
    CHECK(grey_of(big) == Bytes{0, 255, 128, 0});
}

TEST_CASE("ten and twelve bits in sixteen fill the eight") {
    const Bytes bytes{0x00, 0x00, 0xFF, 0x03, 0x00, 0x02, 0xFF, 0x0F};  // 0, 1023, 512, 4095
    const RosImage image = image_of("mono16", 4, 1, 8, bytes);
    GreyImage grey;
    REQUIRE(to_grey(image, 10, grey).empty());
    CHECK(grey.pixels == Bytes{0, 255, 128, 255});
    REQUIRE(to_grey(image, 12, grey).empty());
    CHECK(grey.pixels == Bytes{0, 64, 32, 255});
    CHECK(greatest_wide_sample(image) == 4095);
    CHECK(greatest_wide_sample(image_of("mono8", 4, 1, 8, bytes)) == 0);
    CHECK(greatest_wide_sample(image_of("mono16", 40, 1, 80, bytes)) == 0);
}

TEST_CASE("of YUV the luma is taken") {
    const Bytes pairs{10, 20, 30, 40};
    CHECK(grey_of(image_of("yuv422_yuy2", 2, 1, 4, pairs)) == Bytes{10, 30});
    CHECK(grey_of(image_of("yuyv", 2, 1, 4, pairs)) == Bytes{10, 30});
    CHECK(grey_of(image_of("yuv422", 2, 1, 4, pairs)) == Bytes{20, 40});
    CHECK(grey_of(image_of("uyvy", 2, 1, 4, pairs)) == Bytes{20, 40});
    CHECK(grey_of(image_of("nv12", 2, 2, 2, {1, 2, 3, 4, 128, 128})) == Bytes{1, 2, 3, 4});
    CHECK(grey_of(image_of("nv21", 2, 2, 2, {1, 2, 3, 4, 128, 128})) == Bytes{1, 2, 3, 4});
}

TEST_CASE("colours become luma") {
    CHECK(grey_of(image_of("rgb8", 3, 1, 9, {255, 0, 0, 0, 255, 0, 0, 0, 255})) == Bytes{76, 150, 29});
    CHECK(grey_of(image_of("bgr8", 3, 1, 9, {255, 0, 0, 0, 255, 0, 0, 0, 255})) == Bytes{29, 150, 76});
    CHECK(grey_of(image_of("rgba8", 1, 1, 4, {255, 0, 0, 7})) == Bytes{76});
    CHECK(grey_of(image_of("bgra8", 1, 1, 4, {255, 0, 0, 7})) == Bytes{29});
}

TEST_CASE("a scene of one colour has one luma whatever the pattern of its filters") {
    const std::array<std::uint8_t, 3> colour{200, 100, 40};
    const auto [encoding, pattern] = GENERATE(table<std::string, std::string>(
        {{"bayer_rggb8", "RGGB"}, {"bayer_bggr8", "BGGR"}, {"bayer_gbrg8", "GBRG"}, {"bayer_grbg8", "GRBG"}}));
    Bytes bytes;
    for (std::size_t v = 0; v < 5; ++v) {
        for (std::size_t u = 0; u < 6; ++u) {
            const char filter = pattern[v % 2 * 2 + u % 2];
            bytes.push_back(colour[filter == 'R' ? 0 : filter == 'G' ? 1 : 2]);
        }
    }
    CHECK(grey_of(image_of(encoding, 6, 5, 6, bytes)) == Bytes(30, 123));  // 0.299 * 200 + 0.587 * 100 + 0.114 * 40
}

TEST_CASE("images that are not what they say are refused with a reason") {
    GreyImage grey;
    const Bytes bytes(12, 0);
    CHECK(to_grey(image_of("yuv999", 2, 2, 4, bytes), 16, grey).find("unknown encoding 'yuv999'") != std::string::npos);
    CHECK_FALSE(to_grey(image_of("mono8", 0, 2, 4, bytes), 16, grey).empty());
    CHECK_FALSE(to_grey(image_of("mono8", 4, 4, 4, bytes), 16, grey).empty());
    CHECK_FALSE(to_grey(image_of("mono8", 4, 2, 3, bytes), 16, grey).empty());
    CHECK_FALSE(to_grey(image_of("bgr8", 2, 2, 4, bytes), 16, grey).empty());
    CHECK_FALSE(to_grey(image_of("mono8", 4'000'000'000U, 4'000'000'000U, 4'000'000'000U, bytes), 16, grey).empty());
    CHECK_FALSE(to_grey(image_of("mono8", 1, 16384, 4'000'000'000U, bytes), 16, grey).empty());
}

TEST_CASE("JPEG images are decoded, damaged ones refused") {
    const int channels = GENERATE(3, 1);
    std::string bytes = test::encode_jpeg(20, 10, channels, 140);
    GreyImage grey;
    std::string error;
    const auto read = [&](std::string_view text) {
        return read_jpeg({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, {}, grey, error);
    };
    REQUIRE(ok(read(bytes)));
    CHECK(grey.width == 20);
    CHECK(grey.height == 10);
    for (const std::uint8_t pixel : grey.pixels) {
        CHECK(std::abs(pixel - 140) <= 1);
    }
    const std::string_view whole = bytes;
    for (const std::string_view damaged :
         {whole.substr(0, 20), std::string_view{}, whole.substr(0, whole.size() - 8)}) {
        CHECK(read(damaged) == Status::kCorrupt);
        CHECK(error.find("damaged JPEG") != std::string::npos);
    }
    bytes[3] = 0;
    CHECK(read(bytes) == Status::kCorrupt);
    CHECK(error.find("damaged JPEG") != std::string::npos);
}

}  // namespace facet::grey_image_test
