// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/plane_gravity_factor.h"

#include <catch2/catch.hpp>

#include "tests/support/numeric_jacobian.h"

namespace facet::plane_gravity_factor_test {
namespace {

constexpr double kSigma = 0.01;
constexpr CauchyLoss kNoLoss{1e6};
using Function = decltype(&linearize_level);

PlaneGravityLinearization linearize(Function function, const Plane& plane) {
    PlaneGravityLinearization l;
    function(plane, plane, kSigma, kNoLoss, l);
    return l;
}

Plane turned(const Plane& plane, const Eigen::Vector2d& v) { return plane.box_plus({v.x(), v.y(), 0.0}); }

}  // namespace

TEST_CASE("planes and gravity: Jacobians match central differences", "[plane_gravity]") {
    const Function function = GENERATE(&linearize_level, &linearize_upright);
    const Eigen::Vector3d normal = GENERATE(Eigen::Vector3d(0.1, 0.2, 1.0), Eigen::Vector3d(1.0, 0.2, -0.1));
    const Plane plane = Plane::from(normal.normalized(), 2.0, {2.0, 0.0, 0.0});
    test::expect_jacobian_near(
        linearize(function, plane).d_r_d_v,
        [&](const Eigen::Vector2d& v) { return linearize(function, turned(plane, v)).r; }, Eigen::Vector2d::Zero());
}

TEST_CASE("planes and gravity: level floors, ceilings and upright walls have no residual", "[plane_gravity]") {
    const Plane floor = Plane::from(Eigen::Vector3d::UnitZ(), 1.0, Eigen::Vector3d::Zero());
    const Plane ceiling = Plane::from(-Eigen::Vector3d::UnitZ(), 1.0, Eigen::Vector3d::Zero());
    const Plane wall = Plane::from(Eigen::Vector3d(0.6, 0.8, 0.0), 1.0, Eigen::Vector3d::Zero());
    CHECK(linearize(&linearize_level, floor).r.norm() < 1e-12);
    CHECK(linearize(&linearize_level, ceiling).r.norm() < 1e-12);
    CHECK(linearize(&linearize_upright, wall).r.norm() < 1e-12);
    // One standard deviation off in either direction costs a half.
    CHECK(linearize(&linearize_level, turned(ceiling, {kSigma, 0.0})).cost == Approx(0.5).epsilon(1e-4));
    CHECK(linearize(&linearize_level, turned(floor, {0.0, kSigma})).cost == Approx(0.5).epsilon(1e-4));
}

}  // namespace facet::plane_gravity_factor_test
