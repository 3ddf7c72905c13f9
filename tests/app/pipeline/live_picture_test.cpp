// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/live_picture.h"

#include <catch2/catch.hpp>
#include <numeric>
#include <vector>

namespace facet::live_picture_test {
namespace {

TEST_CASE("a picture is made of means over the smallest squares that make it small enough") {
    // 962 x 5, with rows further apart than that: squares of 3 x 3; the last two columns and rows are left out.
    constexpr int kStride = 970;
    std::vector<std::uint8_t> pixels(5 * kStride);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        pixels[i] = static_cast<std::uint8_t>(i % kStride % 200 + i / kStride);
    }
    ViewPicture picture;
    CHECK(shrink({pixels.data(), 962, 5, kStride}, picture) == 3);
    CHECK(picture.width == 320);
    CHECK(picture.height == 1);
    REQUIRE(picture.pixels.size() == 320);
    CHECK(picture.pixels[0] == 1 + 1);
    CHECK(picture.pixels[10] == 31 + 1);
}

TEST_CASE("an image that is small enough stays as it is") {
    std::vector<std::uint8_t> pixels(48);
    std::iota(pixels.begin(), pixels.end(), std::uint8_t{0});
    ViewPicture picture;
    CHECK(shrink({pixels.data(), 8, 6, 8}, picture) == 1);
    CHECK(picture.pixels == pixels);
}

}  // namespace
}  // namespace facet::live_picture_test
