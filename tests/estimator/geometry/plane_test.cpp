// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/geometry/plane.h"

#include <catch2/catch.hpp>

#include "tests/support/numeric_jacobian.h"

namespace facet::plane_test {

using Tangent = Plane::Tangent;

namespace {

Plane make_plane() { return Plane::from(Eigen::Vector3d(0.3, -0.8, 0.52).normalized(), 1.7, {2.0, -1.0, 0.5}); }

}  // namespace

TEST_CASE("plane: normal, distance and height are those it was made from", "[plane]") {
    const Eigen::Vector3d n = Eigen::Vector3d(0.3, -0.8, 0.52).normalized();
    const Plane plane = make_plane();
    CHECK((plane.normal_W() - n).norm() < 1e-12);
    CHECK(plane.distance_m() == Approx(1.7));
    const Eigen::Vector3d p(4.0, 5.0, 6.0);
    CHECK(plane.height(p) == Approx(n.dot(p) - 1.7));
    const Plane down = Plane::from(-Eigen::Vector3d::UnitZ(), 0.4, Eigen::Vector3d::Zero());  // opposite to the basis
    CHECK((down.normal_W() + Eigen::Vector3d::UnitZ()).norm() < 1e-12);
}

TEST_CASE("plane: box_minus undoes box_plus, normals stay unit", "[plane]") {
    const Tangent d(0.3, -0.2, 0.15);
    const Plane plane = make_plane();
    const Plane moved = plane.box_plus(d);
    CHECK(moved.normal_W().norm() == Approx(1.0));
    CHECK((plane.box_minus_to(moved) - d).norm() < 1e-12);
    CHECK(moved.normal_W().dot(plane.normal_W()) == Approx(std::cos(d.head<2>().norm())));
}

TEST_CASE("plane: derivative of the normal matches central differences", "[plane]") {
    const Plane plane = make_plane();
    test::expect_jacobian_near(
        plane.d_normal_d_v(),
        [&](const Eigen::Vector2d& v) {
            return plane.box_plus({v.x(), v.y(), 0.0}).normal_W();
        },
        Eigen::Vector2d::Zero().eval());
}

}  // namespace facet::plane_test
