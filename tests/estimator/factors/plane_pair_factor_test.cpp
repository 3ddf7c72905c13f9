// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/plane_pair_factor.h"

#include <catch2/catch.hpp>

#include "tests/support/numeric_jacobian.h"

using namespace facet;

namespace {

constexpr double kSigma = 0.01;
constexpr CauchyLoss kNoLoss{1e6};
using Function = decltype(&linearize_parallel);

PlanePairLinearization linearize(Function function, const Plane& a, const Plane& b) {
    PlanePairLinearization l;
    function({&a, &a}, {&b, &b}, kSigma, kNoLoss, l);
    return l;
}

Plane turned(const Plane& plane, const Eigen::Vector2d& v) { return plane.box_plus({v.x(), v.y(), 0.0}); }

}  // namespace

TEST_CASE("plane pairs: Jacobians match central differences", "[plane_pair]") {
    const Function function = GENERATE(&linearize_parallel, &linearize_orthogonal);
    const Plane a = Plane::from(Eigen::Vector3d(1.0, 0.2, -0.1).normalized(), 2.0, {2.0, 0.0, 0.0});
    const Plane b = Plane::from(Eigen::Vector3d(0.7, 0.6, 0.2).normalized(), -1.0, {0.0, 3.0, 0.0});
    const PlanePairLinearization l = linearize(function, a, b);
    const Eigen::Vector2d zero = Eigen::Vector2d::Zero();
    test::expect_jacobian_near(
        l.d_r_d_a, [&](const Eigen::Vector2d& v) { return linearize(function, turned(a, v), b).r; }, zero);
    test::expect_jacobian_near(
        l.d_r_d_b, [&](const Eigen::Vector2d& v) { return linearize(function, a, turned(b, v)).r; }, zero);
}

TEST_CASE("plane pairs: parallel, opposite and orthogonal planes have no residual", "[plane_pair]") {
    const Plane x = Plane::from(Eigen::Vector3d::UnitX(), 1.0, Eigen::Vector3d::Zero());
    const Plane minus_x = Plane::from(-Eigen::Vector3d::UnitX(), 4.0, Eigen::Vector3d::Zero());
    const Plane y = Plane::from(Eigen::Vector3d::UnitY(), 1.0, Eigen::Vector3d::Zero());
    CHECK(linearize(&linearize_parallel, x, minus_x).r.norm() < 1e-12);
    CHECK(linearize(&linearize_orthogonal, x, y).r.norm() < 1e-12);
    // One standard deviation off in either direction costs a half.
    CHECK(linearize(&linearize_parallel, x, turned(minus_x, {kSigma, 0.0})).cost == Approx(0.5).epsilon(1e-4));
    CHECK(linearize(&linearize_parallel, x, turned(minus_x, {0.0, kSigma})).cost == Approx(0.5).epsilon(1e-4));
}
