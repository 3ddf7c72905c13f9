// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/dot_filter.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/estimator/frontend/synthetic.h"

namespace facet::dot_filter_test {
namespace {

constexpr int kWidth = 53;
constexpr int kHeight = 41;

void fill(synthetic::Image& image, int u0, int v0, int width, int height, double grey) {
    for (int v = v0; v < v0 + height; ++v) {
        for (int u = u0; u < u0 + width; ++u) {
            image.set(u, v, grey);
        }
    }
}

/// The definition: the largest of the least values of all squares that contain the pixel, the border repeated.
int opened_by_definition(const synthetic::Image& image, int u, int v) {
    constexpr int kReach = DotFilter::kSide_px / 2;
    const auto at = [&](int x, int y) {
        return image.view().at(std::clamp(x, 0, image.width - 1), std::clamp(y, 0, image.height - 1));
    };
    int largest = 0;
    for (int y = std::max(0, v - kReach); y <= std::min(image.height - 1, v + kReach); ++y) {
        for (int x = std::max(0, u - kReach); x <= std::min(image.width - 1, u + kReach); ++x) {
            int least = 255;
            for (int dy = -kReach; dy <= kReach; ++dy) {
                for (int dx = -kReach; dx <= kReach; ++dx) {
                    least = std::min<int>(least, at(x + dx, y + dy));
                }
            }
            largest = std::max(largest, least);
        }
    }
    return largest;
}

}  // namespace

TEST_CASE("opening follows its definition, up to the borders", "[dots]") {
    synthetic::Image image(kWidth, kHeight);
    std::mt19937 random(3);
    for (auto& pixel : image.pixels) {
        pixel = static_cast<std::uint8_t>(random());
    }
    DotFilter filter;
    filter.configure(kWidth, kHeight);
    const ImageView opened = filter.open(image.view());
    int wrong = 0;
    for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
            wrong += opened.at(u, v) != opened_by_definition(image, u, v) ? 1 : 0;
        }
    }
    CHECK(wrong == 0);
}

TEST_CASE("dots are distinguished from corners and disappear, corners stay where they are", "[dots]") {
    // GIVEN a dot of three pixels and a block of nine
    synthetic::Image image(kWidth, kHeight, 60);
    fill(image, 10, 12, 3, 3, 200);
    fill(image, 30, 20, 9, 9, 200);
    DotFilter filter;
    filter.configure(kWidth, kHeight);
    const ImageView opened = filter.open(image.view());
    CHECK(opened.at(11, 13) == 60);
    CHECK(opened.at(30, 20) == 200);
    CHECK(opened.at(29, 20) == 60);
    CHECK(DotFilter::is_dot(image.view(), opened, {11.2, 12.8}));
    CHECK_FALSE(DotFilter::is_dot(image.view(), opened, {30.0, 20.0}));
    CHECK_FALSE(DotFilter::is_dot(image.view(), opened, {0.0, 0.0}));  // a flat place at the border
    CHECK(DotFilter::share(image.view(), opened) == Approx(9.0 / (kWidth * kHeight)));
}

}  // namespace facet::dot_filter_test
