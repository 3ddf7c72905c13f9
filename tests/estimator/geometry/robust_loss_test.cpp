// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/geometry/robust_loss.h"

#include <catch2/catch.hpp>
#include <vector>

namespace facet::robust_loss_test {
namespace {

const std::vector<LossKind> kKinds{LossKind::kHuber, LossKind::kCauchy, LossKind::kTukey};

}  // namespace

TEST_CASE("a loss's weight is the derivative of twice its cost, and small residuals keep theirs", "[robust_loss]") {
    const RobustLoss loss{GENERATE(0.5, 1.0, 2.0), GENERATE_REF(from_range(kKinds))};
    for (const double s : {1e-4, 0.1, 0.9, 3.0, 50.0, 1e4}) {
        const double h = 1e-5 * s;
        CHECK(loss.weight(s) == Approx((loss.cost(s + h) - loss.cost(s - h)) / h).epsilon(1e-4));
    }
    CHECK(loss.weight(1e-6) == Approx(1.0).epsilon(1e-4));
    CHECK(loss.cost(1e-6) == Approx(0.5e-6).epsilon(1e-4));
}

TEST_CASE("a loss's slope is how its influence grows, on average along and across the residual", "[robust_loss]") {
    const RobustLoss loss{1.2, GENERATE_REF(from_range(kKinds))};
    const auto influence = [&](double r) { return loss.weight(r * r) * r; };
    for (const double r : {0.1, 0.9, 2.0, 7.0}) {
        const double h = 1e-5 * r;
        const double along = (influence(r + h) - influence(r - h)) / (2.0 * h);
        const double across = influence(r) / r;
        CHECK(loss.slope(r * r) == Approx(0.5 * (along + across)).epsilon(1e-4));
    }
}

TEST_CASE("the cost of several residuals is the sum of their costs, however large", "[robust_loss]") {
    const RobustLoss loss{GENERATE(0.5, 1.2), GENERATE_REF(from_range(kKinds))};
    std::vector<double> squares;
    double sum = 0.0;
    CHECK(loss.cost(squares) == 0.0);
    for (int i = 0; i < 400; ++i) {
        squares.push_back(i % 3 == 0 ? 1e12 * i : 0.01 * i);
        sum += loss.cost(squares.back());
    }
    CHECK(loss.cost(squares) == Approx(sum).epsilon(1e-12));
}

TEST_CASE("far residuals pull with constant force under Huber's loss, and less and less under Cauchy's",
          "[robust_loss]") {
    const auto pull = [](const auto& loss, double r) { return loss.weight(r * r) * r; };
    CHECK(pull(HuberLoss{1.5}, 1000.0) == Approx(pull(HuberLoss{1.5}, 10.0)));
    CHECK(pull(CauchyLoss{1.5}, 1000.0) < 0.02 * pull(CauchyLoss{1.5}, 10.0));
}

TEST_CASE("beyond its threshold a residual has no influence under Tukey's loss", "[robust_loss]") {
    const TukeyLoss loss{2.0};
    CHECK(loss.weight(3.99) > 0.0);
    CHECK(loss.weight(4.01) == 0.0);
    CHECK(loss.cost(4.0) == Approx(loss.cost(1e6)));
}

TEST_CASE("a precision under Tukey's loss is a narrower standard deviation", "[robust_loss]") {
    const TukeyLoss narrow{3.0, 4.0};  // half of the standard deviation: residuals count twice as large
    for (const double s : {0.01, 0.5, 2.0, 5.0}) {
        CHECK(narrow.cost(s) == Approx(TukeyLoss{3.0}.cost(4.0 * s)));
        CHECK(narrow.weight(s) == Approx(4.0 * TukeyLoss{3.0}.weight(4.0 * s)));
        CHECK(narrow.slope(s) == Approx(4.0 * TukeyLoss{3.0}.slope(4.0 * s)));
    }
}

}  // namespace facet::robust_loss_test
