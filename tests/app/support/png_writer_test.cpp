// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/png_writer.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/support/temp_dir.h"

namespace facet::png_writer_test {
namespace {

TEST_CASE("a PNG in memory is that of the file") {
    const test::TempDir dir;
    std::vector<std::uint8_t> pixels(40 * 30);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        pixels[i] = static_cast<std::uint8_t>(i * i / 7);
    }
    const ImageView image{pixels.data(), 37, 30, 40};
    const std::string path = dir.path() + "/image.png";
    REQUIRE(ok(write_png(path, image)));
    std::ifstream file(path, std::ios::binary);
    const std::vector<std::uint8_t> written{std::istreambuf_iterator<char>(file), {}};
    std::vector<std::uint8_t> made{1, 2, 3};
    REQUIRE(ok(encode_png(image, made)));
    CHECK(made == written);
    CHECK(made.size() > 100);
    CHECK(encode_png({}, made) == Status::kInvalidArgument);
    CHECK(made == written);
}

TEST_CASE("runs of one value and the noise of a camera are both compressed") {
    constexpr int kSide = 256;
    std::vector<std::uint8_t> pixels(kSide * kSide);
    std::vector<std::uint8_t> made;
    REQUIRE(ok(encode_png({pixels.data(), kSide, kSide, kSide}, made)));
    CHECK(made.size() < pixels.size() / 100);
    std::minstd_rand draw(1);
    for (std::size_t i = 0; i < pixels.size(); ++i) {  // a ramp, and noise of three bits
        pixels[i] = static_cast<std::uint8_t>(i % kSide / 2 + i / kSide / 4 + draw() / 7 % 8);
    }
    REQUIRE(ok(encode_png({pixels.data(), kSide, kSide, kSide}, made)));
    CHECK(made.size() < pixels.size() / 2);
}

}  // namespace
}  // namespace facet::png_writer_test
