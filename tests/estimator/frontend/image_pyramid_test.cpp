// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/image_pyramid.h"

#include <catch2/catch.hpp>

#include "tests/estimator/frontend/synthetic.h"

using namespace facet;

TEST_CASE("pyramid refuses sizes it cannot halve", "[frontend]") {
    ImagePyramid pyramid;
    REQUIRE(pyramid.configure(320, 240, 0) == Status::kInvalidArgument);
    REQUIRE(pyramid.configure(320, 240, 7) == Status::kInvalidArgument);
    REQUIRE(pyramid.configure(60, 60, 3) == Status::kInvalidArgument);
    REQUIRE(ok(pyramid.configure(64, 64, 3)));
}

TEST_CASE("pixel (u, v) of a level is pixel (2u, 2v) of the one below", "[frontend]") {
    // A ramp stays a ramp under symmetric filters, so that any shift between the levels would show as an offset.
    synthetic::Image image(161, 121);
    for (int v = 0; v < image.height; ++v) {
        for (int u = 0; u < image.width; ++u) {
            image.set(u, v, u + 0.5 * v);
        }
    }
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(image.width, image.height, 3)));
    pyramid.build(image.view());
    REQUIRE(pyramid.level(1).width == 81);
    REQUIRE(pyramid.level(2).height == 31);
    for (int l = 0; l < 3; ++l) {
        const ImageView& view = pyramid.level(l);
        for (int v = 4; v < view.height - 4; ++v) {
            for (int u = 4; u < view.width - 4; ++u) {
                const double expected = (u + 0.5 * v) * (1 << l);
                REQUIRE(std::abs(view.at(u, v) - expected) <= 1.5);
            }
        }
    }
}

TEST_CASE("pyramid keeps no reference to the image", "[frontend]") {
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(64, 48, 2)));
    synthetic::Image image(64, 48, 100);
    pyramid.build(image.view());
    std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{0});
    REQUIRE(pyramid.level(0).at(10, 10) == 100);
    REQUIRE(pyramid.level(1).at(10, 10) == 100);
}
