// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/image_faults.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

namespace facet::image_faults_test {
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

TEST_CASE("another exposure multiplies and saturates") {
    GreyImage image = ramp(256, 2);
    expose(16.0, image);
    CHECK(image.pixels[0] == 0);
    CHECK(image.pixels[5] == 80);
    CHECK(image.pixels[15] == 240);
    CHECK(image.pixels[16] == 255);
    CHECK(image.pixels[255] == 255);
    expose(0.1, image);
    CHECK(image.pixels[5] == 8);
    CHECK(image.pixels[255] == 26);
}

/// Mean and standard deviation of the pixels for which `is_wanted(u, v)`.
template <class Wanted>
std::pair<double, double> figures(const GreyImage& image, Wanted is_wanted) {
    double sum = 0.0;
    double square = 0.0;
    double n = 0.0;
    for (int v = 0; v < image.height; ++v) {
        for (int u = 0; u < image.width; ++u) {
            const double p = image.view().at(u, v);
            const double weight = is_wanted(u, v) ? 1.0 : 0.0;
            sum += weight * p;
            square += weight * p * p;
            n += weight;
        }
    }
    return {sum / n, std::sqrt(square / n - sum * sum / (n * n))};
}

TEST_CASE("a wall without texture is one grey with the noise of the sensor") {
    GreyImage image = ramp(200, 100);
    whiten(1, image);
    const auto [mean, sigma] = figures(image, [](int, int) { return true; });
    CHECK(mean == Approx(120.0).margin(0.2));
    CHECK(sigma == Approx(1.5).margin(0.1));
}

TEST_CASE("noise of pixels has its size, no mean, and another seed another noise") {
    GreyImage image = ramp(200, 100);
    whiten(1, image);
    GreyImage other = image;
    add_pixel_noise(20.0, 2, image);
    add_pixel_noise(20.0, 3, other);
    CHECK(image.pixels != other.pixels);
    const auto [mean, sigma] = figures(image, [](int, int) { return true; });
    CHECK(mean == Approx(120.0).margin(0.5));
    CHECK(sigma == Approx(20.0).epsilon(0.03));
}

TEST_CASE("a smear takes the detail within a disk and leaves the rest") {
    constexpr int kWidth = 160;
    constexpr int kHeight = 100;
    GreyImage image{.width = kWidth, .height = kHeight, .pixels = {}};
    for (int i = 0; i < kWidth * kHeight; ++i) {
        image.pixels.push_back((i % kWidth + i / kWidth) % 2 == 0 ? 40 : 200);
    }
    const GreyImage before = image;
    smear(image);
    const auto is_inside = [](double radius) {
        return [radius](int u, int v) { return std::hypot(u - 0.4 * kWidth, v - 50.0) < radius; };
    };
    const auto [mean, sigma] = figures(image, is_inside(25.0));
    CHECK(mean == Approx(135.0).margin(1.0));  // half of 120, half of the veil's 150
    CHECK(sigma < 1.0);
    int changed = 0;
    for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
            const bool is_changed = image.view().at(u, v) != before.view().at(u, v);
            changed += is_changed ? 1 : 0;
            CHECK((is_inside(41.0)(u, v) || !is_changed));
        }
    }
    CHECK(changed == Approx(3.14 * 40.0 * 40.0).epsilon(0.03));
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
}  // namespace facet::image_faults_test
