// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/image_faults.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

namespace facet {
namespace {

GreyImage ramp(int width, int height) {
    GreyImage image{.width = width, .height = height, .pixels = {}};
    for (int i = 0; i < width * height; ++i) {
        image.pixels.push_back(static_cast<std::uint8_t>(i % 256));
    }
    return image;
}

TEST_CASE("a blackout leaves noise near black that differs from seed to seed") {
    GreyImage image = ramp(200, 100);
    GreyImage other = image;
    black_out(1, image);
    black_out(2, other);
    CHECK(image.pixels != other.pixels);
    double mean = 0.0;
    double square = 0.0;
    for (const std::uint8_t p : image.pixels) {
        mean += p;
        square += p * p;
    }
    const auto n = static_cast<double>(image.pixels.size());
    mean /= n;
    CHECK(mean == Approx(2.0).margin(0.2));
    CHECK(std::sqrt(square / n - mean * mean) == Approx(1.5).margin(0.2));
    CHECK(*std::max_element(image.pixels.begin(), image.pixels.end()) < 10);
}

TEST_CASE("overexposure multiplies and saturates") {
    GreyImage image = ramp(256, 2);
    overexpose(16.0, image);
    CHECK(image.pixels[0] == 0);
    CHECK(image.pixels[5] == 80);
    CHECK(image.pixels[15] == 240);
    CHECK(image.pixels[16] == 255);
    CHECK(image.pixels[255] == 255);
}

TEST_CASE("a copy drops the padding of rows and keeps the size") {
    const GreyImage source = ramp(8, 4);
    GreyImage copy;
    copy_image({.data = source.pixels.data() + 1, .width = 5, .height = 4, .stride = 8}, copy);
    CHECK(copy.width == 5);
    CHECK(copy.height == 4);
    REQUIRE(copy.pixels.size() == 20);
    for (int v = 0; v < 4; ++v) {
        CHECK(copy.view().at(4, v) == 8 * v + 5);
    }
    copy_image({}, copy);
    CHECK(copy.view().empty());
}

}  // namespace
}  // namespace facet
