// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/image_check.h"

#include <catch2/catch.hpp>

#include "tests/estimator/frontend/synthetic.h"

namespace facet::image_check_test {

using synthetic::Image;

namespace {

Image with_texture(double gain, double offset) {
    return synthetic::warp(synthetic::Texture(6.0, 40.0, 5), 188, 120, Eigen::Vector2d::Zero(),
                           Eigen::Matrix2d::Identity(), gain, offset);
}

}  // namespace

TEST_CASE("an image with contrast can be tracked, a dim one too", "[image_check]") {
    CHECK(check_image(with_texture(1.0, 0.0).view()) == ImageState::kUsable);
    CHECK(check_image(with_texture(0.2, 0.0).view()) == ImageState::kUsable);
}

TEST_CASE("dark, overexposed and flat images are distinguished", "[image_check]") {
    CHECK(check_image(Image(188, 120, 4).view()) == ImageState::kDark);
    CHECK(check_image(with_texture(0.05, 0.0).view()) == ImageState::kDark);
    CHECK(check_image(Image(188, 120, 255).view()) == ImageState::kOverexposed);
    CHECK(check_image(with_texture(1.0, 300.0).view()) == ImageState::kOverexposed);
    CHECK(check_image(Image(188, 120, 120).view()) == ImageState::kFlat);
}

TEST_CASE("the same image is one that is equal everywhere it is looked at", "[image_check]") {
    const Image a = with_texture(1.0, 0.0);
    Image b = a;
    CHECK(is_same_image(a.view(), b.view()));
    b.pixels[16U * 188U + 100U] ^= 1U;
    CHECK_FALSE(is_same_image(a.view(), b.view()));
}

TEST_CASE("relative contrast is that of the scene, whatever gain and exposure", "[image_check]") {
    const double usual = relative_contrast(with_texture(1.0, 0.0).view());
    CHECK(relative_contrast(with_texture(0.5, 0.0).view()) == Approx(usual).epsilon(0.05));
    CHECK(relative_contrast(with_texture(0.5, 60.0).view()) < 0.8 * usual);
    CHECK(relative_contrast(Image(188, 120, 0).view()) == 0.0);
    CHECK(relative_contrast({}) == 0.0);
    Image dots = with_texture(1.0, 0.0);
    for (std::size_t i = 0; i < dots.pixels.size(); i += 7) {
        dots.pixels[i] = 255;
    }
    CHECK(relative_contrast(dots.view()) > 1.5 * usual);
}

}  // namespace facet::image_check_test
