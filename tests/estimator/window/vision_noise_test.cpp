// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/vision_noise.h"

#include <catch2/catch.hpp>
#include <limits>

namespace facet {
namespace {

VisionNoise learned(double configured_px, double shown_px, int keyframes) {
    VisionNoise noise;
    noise.reset(configured_px, true);
    for (int k = 0; k < keyframes; ++k) {
        noise.measure(shown_px * shown_px * 500, 500);
        noise.learn();
    }
    return noise;
}

}  // namespace

TEST_CASE("weights follow what residuals show", "[window]") {
    CHECK(learned(0.5, 0.3, 0).sigma_px() == 0.5);
    CHECK(learned(0.5, 0.3, 100).sigma_px() == Approx(0.3 * VisionNoise::kCorrelation).epsilon(1e-3));
    CHECK(learned(0.5, 0.3, 100).measured_px() == Approx(0.3));
    // A mean of variances at first, with the configured one as one of them.
    const double end = 0.6 * VisionNoise::kCorrelation;
    CHECK(std::pow(learned(0.5, 0.6, 3).sigma_px(), 2) == Approx((0.25 + 3 * end * end) / 4));
}

TEST_CASE("weights stay within reach of the configured ones", "[window]") {
    CHECK(learned(0.5, 0.01, 200).sigma_px() == Approx(0.25).epsilon(1e-3));
    CHECK(learned(0.5, 30.0, 200).sigma_px() == Approx(1.0).epsilon(1e-3));
}

TEST_CASE("too few residuals, or none that are numbers, teach nothing", "[window]") {
    VisionNoise noise;
    noise.reset(0.5, true);
    noise.measure(1.0, VisionNoise::kEnoughRows - 1);
    noise.measure(std::numeric_limits<double>::quiet_NaN(), 500);
    CHECK(noise.measured_px() == Approx(0.5 / VisionNoise::kCorrelation));
    noise.learn();
    CHECK(noise.sigma_px() == Approx(0.5));
}

TEST_CASE("a configured sigma that is not to be learned stays", "[window]") {
    VisionNoise noise;
    noise.reset(0.5, false);
    noise.measure(500.0, 500);
    noise.learn();
    CHECK(noise.sigma_px() == 0.5);
    CHECK(noise.measured_px() == Approx(1.0));
}

}  // namespace facet
