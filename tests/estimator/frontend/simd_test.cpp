// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/simd.h"

#include <catch2/catch.hpp>

#include "estimator/frontend/image_pyramid.h"
#include "tests/estimator/frontend/synthetic.h"

namespace facet::simd_test {

TEST_CASE("sampling interpolates bilinearly up to the last pixels", "[frontend]") {
    const int width = 37;
    const int height = 29;
    const synthetic::Image image = synthetic::warp(synthetic::Texture(4.0, 20.0, 8), width, height, {0.0, 0.0});
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(width, height, 1)));
    pyramid.build(image.view());
    const ImageView view = image.view();
    for (float v = 0.0F; v < static_cast<float>(height - 1); v += 0.37F) {
        for (float u = 0.0F; u + 0.31F * simd::kLanes < static_cast<float>(width - 1); u += 0.83F) {
            simd::Floats us = simd::splat(u);
            for (int i = 0; i < simd::kLanes; ++i) {
                us[i] += 0.31F * static_cast<float>(i);
            }
            const simd::Floats found = simd::sample(pyramid.pairs(0), us, simd::splat(v));
            for (int i = 0; i < simd::kLanes; ++i) {
                const int iu = static_cast<int>(us[i]);
                const int iv = static_cast<int>(v);
                const double fu = us[i] - static_cast<float>(iu);
                const double fv = v - static_cast<float>(iv);
                const double expected = (1.0 - fv) * ((1.0 - fu) * view.at(iu, iv) + fu * view.at(iu + 1, iv)) +
                                        fv * ((1.0 - fu) * view.at(iu, iv + 1) + fu * view.at(iu + 1, iv + 1));
                REQUIRE(std::abs(found[i] - expected) < 1e-3);
            }
        }
    }
}

TEST_CASE("sampling along a curve gives the same, whichever way it runs", "[frontend]") {
    const int width = 75;
    const int height = 41;
    const synthetic::Image image = synthetic::warp(synthetic::Texture(4.0, 20.0, 8), width, height, {0.0, 0.0});
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(width, height, 1)));
    pyramid.build(image.view());
    for (const float along : {1.0F, -1.0F, 0.6F, -1.7F, 3.0F, 0.0F}) {
        for (const float across : {0.0F, 0.03F, -0.4F, 1.0F}) {
            for (float v = 10.5F; v < 30.0F; v += 0.77F) {
                simd::Floats us{};
                simd::Floats vs{};
                for (int i = 0; i < simd::kLanes; ++i) {
                    us[i] = 37.2F + v + along * static_cast<float>(i - 4);
                    vs[i] = v + across * static_cast<float>(i - 4);
                }
                us = simd::clamp(us, 0.0F, 73.9F);
                CHECK(
                    !simd::any(simd::sample(pyramid.pairs(0), us, vs) != simd::sample<true>(pyramid.pairs(0), us, vs)));
            }
        }
    }
    // Not in order: the outermost are in the middle.
    simd::Floats us = simd::splat(20.5F);
    us[1] = 19.5F;
    us[2] = 30.5F;
    CHECK(!simd::any(simd::sample(pyramid.pairs(0), us, us) != simd::sample<true>(pyramid.pairs(0), us, us)));
}

TEST_CASE("sampling in integers gives exact products of shares of 4096 across and 255 down", "[frontend]") {
    const int width = 67;
    const int height = 41;
    const synthetic::Image image = synthetic::warp(synthetic::Texture(4.0, 20.0, 8), width, height, {0.0, 0.0});
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(width, height, 1)));
    pyramid.build(image.view());
    const ImageView view = image.view();
    for (int fixed_v = 0; fixed_v < 4096 * (height - 1); fixed_v += 379) {
        for (int first = 0; first + 1270 * simd::kLanes < 4096 * (width - 1); first += 3391) {
            simd::Floats u{};
            for (int i = 0; i < simd::kLanes; ++i) {
                u[i] = static_cast<float>(first + 1270 * i);
            }
            const simd::Floats found =
                simd::sample_scaled(pyramid.pairs(0), u, simd::splat(static_cast<float>(fixed_v)));
            for (int i = 0; i < simd::kLanes; ++i) {
                const int fixed_u = first + 1270 * i;
                const int iu = fixed_u / 4096;
                const int iv = fixed_v / 4096;
                const int fu = fixed_u % 4096;
                const int fv = fixed_v % 4096 / 16;
                const auto column = [&](int at) {
                    return (255 - fv) * (view.at(at, iv) - 128) + fv * (view.at(at, iv + 1) - 128);
                };
                REQUIRE(found[i] == static_cast<float>((4096 - fu) * column(iu) + fu * column(iu + 1)));
            }
        }
    }
}

TEST_CASE("vectors load, store, add up and compare like their lanes", "[frontend]") {
    std::uint8_t bytes[simd::kOverread] = {};
    float floats[simd::kLanes] = {};
    float sum = 0.0F;
    for (int i = 0; i < simd::kLanes; ++i) {
        bytes[i] = static_cast<std::uint8_t>(250 - 17 * i);
        sum += bytes[i];
    }
    const simd::Floats v = simd::load_bytes(bytes);
    simd::store(floats, v);
    for (int i = 0; i < simd::kLanes; ++i) {
        CHECK(floats[i] == bytes[i]);
        CHECK(simd::load(floats)[i] == bytes[i]);
        CHECK(simd::clamp(v, 140.0F, 240.0F)[i] == std::clamp(floats[i], 140.0F, 240.0F));
        simd::Floats one{};
        one[i] = 1.0F;
        CHECK(simd::any(one > 0.5F));
        CHECK(simd::greatest(one) == 1.0F);
        CHECK(simd::sum(one) == 1.0F);
    }
    CHECK(simd::sum(v) == sum);
    const simd::Floats squares = simd::multiply_add(v, v, simd::splat(3.0F));
    for (int i = 0; i < simd::kLanes; ++i) {
        CHECK(squares[i] == floats[i] * floats[i] + 3.0F);  // whole numbers below 2^24: exact either way
    }
    CHECK(!simd::any(v > 250.0F));
}

}  // namespace facet::simd_test
