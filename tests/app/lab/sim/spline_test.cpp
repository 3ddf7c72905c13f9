// SPDX-License-Identifier: BSD-2-Clause
// Quintic spline: derivatives against numeric differentiation, continuity, convex hull, reproduction of lines.
#include "app/lab/sim/spline.h"

#include <catch2/catch.hpp>

#include "app/support/rng.h"

namespace facet::sim::spline_test {
namespace {

QuinticSpline<3> random_spline(std::uint64_t seed) {
    RandomStream random(seed, 1);
    std::vector<Eigen::Vector3d> control;
    for (int i = 0; i < 14; ++i) {
        control.emplace_back(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    }
    return {0.4, control};
}

TEST_CASE("Spline derivatives agree with numeric differentiation") {
    const double h = 1e-5;
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        const QuinticSpline<3> s = random_spline(seed);
        for (double t = 0.1; t < s.duration_s() - 0.1; t += 0.037) {
            const auto before = s.evaluate(t - h);
            const auto at = s.evaluate(t);
            const auto after = s.evaluate(t + h);
            CHECK((at.d1 - (after.x - before.x) / (2.0 * h)).norm() < 1e-7);
            CHECK((at.d2 - (after.d1 - before.d1) / (2.0 * h)).norm() < 1e-6);
        }
    }
}

TEST_CASE("Spline is smooth across knots and stays within the hull of its control points") {
    const QuinticSpline<3> s = random_spline(4);
    const double e = 1e-9;
    for (int knot = 1; knot * 0.4 < s.duration_s() - 0.2; ++knot) {
        const auto left = s.evaluate(knot * 0.4 - e);
        const auto right = s.evaluate(knot * 0.4 + e);
        CHECK((left.x - right.x).norm() < 1e-7);
        CHECK((left.d1 - right.d1).norm() < 1e-6);
        CHECK((left.d2 - right.d2).norm() < 1e-5);
    }
    for (double t = 0.0; t <= s.duration_s(); t += 0.01) {
        CHECK(s.evaluate(t).x.cwiseAbs().maxCoeff() <= 1.0);
    }
}

TEST_CASE("Spline of points on a line at equal distances is that uniform motion") {
    std::vector<Eigen::Matrix<double, 1, 1>> control;
    for (int i = 0; i < 10; ++i) {
        control.emplace_back(0.3 * i);
    }
    const QuinticSpline<1> s(0.5, control);
    CHECK(s.duration_s() == Approx(2.5));
    for (double t = 0.0; t <= 2.5; t += 0.1) {
        CHECK(s.evaluate(t).x[0] == Approx(0.6 + 0.6 * t));
        CHECK(s.evaluate(t).d1[0] == Approx(0.6));
        CHECK(std::abs(s.evaluate(t).d2[0]) < 1e-12);
    }
}

}  // namespace
}  // namespace facet::sim::spline_test
