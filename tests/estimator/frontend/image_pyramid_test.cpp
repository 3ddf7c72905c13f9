// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/image_pyramid.h"

#include <catch2/catch.hpp>

#include "tests/estimator/frontend/synthetic.h"

namespace facet::image_pyramid_test {

TEST_CASE("pyramid refuses sizes it cannot halve", "[frontend]") {
    ImagePyramid pyramid;
    REQUIRE(pyramid.configure(320, 240, 0) == Status::kInvalidArgument);
    REQUIRE(pyramid.configure(320, 240, 7) == Status::kInvalidArgument);
    REQUIRE(pyramid.configure(60, 60, 3) == Status::kInvalidArgument);
    REQUIRE(pyramid.configure(4097, 240, 3) == Status::kInvalidArgument);
    REQUIRE(pyramid.configure(320, 4097, 3) == Status::kInvalidArgument);
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

TEST_CASE("a level is the binomial filter of the one below, mirrored at the border", "[frontend]") {
    const auto [width, height] = GENERATE(std::pair{96, 64}, std::pair{75, 53}, std::pair{35, 33});
    synthetic::Image image = synthetic::warp(synthetic::Texture(3.0, 20.0, 9), width, height, {0.0, 0.0});
    std::fill_n(image.pixels.begin(), 5 * width, std::uint8_t{255});  // the greatest sums there can be
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(width, height, 2)));
    pyramid.build(image.view());
    REQUIRE(pyramid.level(1).width == (width + 1) / 2);
    REQUIRE(pyramid.level(1).height == (height + 1) / 2);
    const int weights[] = {1, 4, 6, 4, 1};
    const auto mirrored = [](int i, int size) { return i < 0 ? -i : (i >= size ? 2 * size - 2 - i : i); };
    for (int v = 0; v < pyramid.level(1).height; ++v) {
        for (int u = 0; u < pyramid.level(1).width; ++u) {
            int sum = 0;
            for (int y = -2; y <= 2; ++y) {
                for (int x = -2; x <= 2; ++x) {
                    sum += weights[x + 2] * weights[y + 2] *
                           image.view().at(mirrored(2 * u + x, width), mirrored(2 * v + y, height));
                }
            }
            REQUIRE(static_cast<int>(pyramid.level(1).at(u, v)) == (sum + 128) / 256);
        }
    }
}

TEST_CASE("pairs hold each pixel and the one below it", "[frontend]") {
    const auto [width, height] = GENERATE(std::pair{96, 20}, std::pair{75, 21}, std::pair{19, 17});
    const synthetic::Image image = synthetic::warp(synthetic::Texture(3.0, 20.0, 9), width, height, {0.0, 0.0});
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(width, height, 1)));
    pyramid.build(image.view());
    const RowPairs& pairs = pyramid.pairs(0);
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
            const int below = image.view().at(u, std::min(v + 1, height - 1));
            REQUIRE(pairs.data[v * pairs.stride + u] == image.view().at(u, v) + 256 * below);
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

}  // namespace facet::image_pyramid_test
