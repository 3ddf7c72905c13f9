// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/residual_bias.h"

#include <catch2/catch.hpp>
#include <limits>

namespace facet::residual_bias_test {

TEST_CASE("the bias of residuals is the largest weighted mean, once enough is known", "[window]") {
    ResidualBias bias;
    const Eigen::Vector4d means(0.02, -0.11, 0.05, 0.01);
    const Eigen::Vector2d weights(2000.0, 1000.0);
    const Eigen::Vector4d sums(means(0) * 2000.0, means(1) * 2000.0, means(2) * 1000.0, means(3) * 1000.0);
    bias.add(sums, weights);
    CHECK(bias.largest_px() == 0.0);
    for (int k = 0; k < 6; ++k) {
        bias.add(sums, weights);
    }
    CHECK(bias.largest_px() == Approx(0.11));
    // It forgets: after a calibration has been corrected the means vanish.
    for (int k = 0; k < 60; ++k) {
        bias.add(Eigen::Vector4d::Zero(), weights);
    }
    CHECK(bias.largest_px() < 0.01);
}

TEST_CASE("the bias of residuals ignores sums that are NaN, and one camera alone speaks for itself", "[window]") {
    ResidualBias bias;
    for (int k = 0; k < 20; ++k) {
        bias.add(Eigen::Vector4d(300.0, 0.0, 0.0, 0.0), {3000.0, 0.0});
        bias.add(Eigen::Vector4d::Constant(std::numeric_limits<double>::quiet_NaN()), {3000.0, 3000.0});
    }
    CHECK(bias.largest_px() == Approx(0.1));
    bias.reset();
    CHECK(bias.largest_px() == 0.0);
}

}  // namespace facet::residual_bias_test
