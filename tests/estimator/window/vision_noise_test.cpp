// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/vision_noise.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

namespace facet {
namespace {

/// Residuals of this deviation.
void show(VisionNoise& noise, double px, int rows = 500) { noise.measure(px * px * rows, rows); }

VisionNoise learned(double configured_px, double shown_px, int keyframes) {
    VisionNoise noise;
    noise.reset(configured_px, true);
    for (int k = 0; k < keyframes; ++k) {
        show(noise, shown_px);
        noise.learn();
    }
    return noise;
}

}  // namespace

TEST_CASE("weights follow what residuals show", "[window]") {
    CHECK(learned(0.5, 0.3, 0).sigma_px() == 0.5);
    CHECK(learned(0.5, 0.3, 100).sigma_px() == Approx(0.3).epsilon(1e-3));
    CHECK(learned(0.5, 0.3, 100).measured_px() == Approx(0.3));
    // A mean of variances at first, with the configured one as one of them.
    CHECK(std::pow(learned(0.5, 0.8, 3).sigma_px(), 2) == Approx((0.25 + 3 * 0.64) / 4));
}

TEST_CASE("weights stay within reach of the configured ones", "[window]") {
    CHECK(learned(0.5, 0.01, 200).sigma_px() == Approx(0.05).epsilon(1e-3));
    CHECK(learned(0.5, 30.0, 200).sigma_px() == Approx(5.0).epsilon(1e-3));
}

TEST_CASE("too few residuals, or none that are numbers, teach nothing", "[window]") {
    VisionNoise noise;
    noise.reset(0.5, true);
    show(noise, 0.1, VisionNoise::kEnoughRows - 1);
    show(noise, std::numeric_limits<double>::quiet_NaN());
    CHECK(noise.measured_px() == 0.5);
    noise.learn();
    CHECK(noise.sigma_px() == Approx(0.5));
}

TEST_CASE("a configured sigma that is not to be learned stays", "[window]") {
    VisionNoise noise;
    noise.reset(0.5, false);
    show(noise, 1.0);
    noise.learn();
    CHECK(noise.sigma_px() == 0.5);
    CHECK(noise.measured_px() == Approx(1.0));
    CHECK(noise.cautious_px() == 0.5);
}

}  // namespace facet
