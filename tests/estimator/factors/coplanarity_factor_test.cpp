// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/coplanarity_factor.h"

#include <catch2/catch.hpp>

#include "tests/support/numeric_jacobian.h"

namespace facet::coplanarity_factor_test {
namespace {

constexpr double kSigma = 0.02;
constexpr HuberLoss kNoLoss{1e9};

struct Scene {
    CameraPose host = CameraPose::from(Se3{so3_exp({0.2, -0.4, 0.7}), {0.3, 1.2, -0.5}});
    InverseDepthPoint point{{0.15, -0.1}, 0.4};
    Plane plane = Plane::from(Eigen::Vector3d(0.2, 0.1, -0.9).normalized(), -2.0, {0.5, 1.0, 2.0});
};

CoplanarityLinearization linearize(const Plane& plane, const Plane& plane_lin, const CameraPose& host,
                                   const InverseDepthPoint& point, const HuberLoss& loss = kNoLoss) {
    CoplanarityLinearization l;
    REQUIRE(ok(linearize_coplanarity(plane, plane_lin, host, point, kSigma, loss, l)));
    return l;
}

}  // namespace

TEST_CASE("co-planarity: the residual is the whitened height", "[coplanarity]") {
    const Scene s;
    const CoplanarityLinearization l = linearize(s.plane, s.plane, s.host, s.point);
    CHECK(l.r == Approx(s.plane.height(ScaledWorldPoint(s.host, s.point).p_W()) / kSigma));
    CHECK(l.cost == Approx(0.5 * l.r * l.r));
}

TEST_CASE("co-planarity: Jacobians match central differences", "[coplanarity]") {
    const Scene s;
    const CoplanarityLinearization l = linearize(s.plane, s.plane, s.host, s.point);
    test::expect_jacobian_near(
        l.d_r_d_plane,
        [&](const Eigen::Vector3d& d) {
            const Plane moved = s.plane.box_plus(d);
            return Eigen::Matrix<double, 1, 1>(linearize(moved, moved, s.host, s.point).r);
        },
        Eigen::Vector3d::Zero().eval());
    test::expect_jacobian_near(
        l.d_r_d_point,
        [&](const Eigen::Vector3d& d) {
            const InverseDepthPoint moved{s.point.xy + d.head<2>(), s.point.rho + d.z()};
            return Eigen::Matrix<double, 1, 1>(linearize(s.plane, s.plane, s.host, moved).r);
        },
        Eigen::Vector3d::Zero().eval());
}

TEST_CASE("co-planarity: Jacobians at the first estimate, residual at the present one", "[coplanarity]") {
    const Scene s;
    const Plane lin = s.plane.box_plus({0.1, -0.05, 0.2});
    const CoplanarityLinearization mixed = linearize(s.plane, lin, s.host, s.point);
    CHECK(mixed.r == Approx(linearize(s.plane, s.plane, s.host, s.point).r));
    CHECK(mixed.d_r_d_plane.isApprox(linearize(lin, lin, s.host, s.point).d_r_d_plane));
    CHECK(mixed.d_r_d_point.isApprox(linearize(lin, lin, s.host, s.point).d_r_d_point));
}

TEST_CASE("co-planarity: moving world and plane together says nothing", "[coplanarity]") {
    // A shift t of the point, n . t, is undone by the same shift of the plane; a yaw likewise.
    const Scene s;
    const CoplanarityLinearization l = linearize(s.plane, s.plane, s.host, s.point);
    const double d_r_d_shift = s.plane.normal_W().x() / kSigma;  // of the point along x
    CHECK(d_r_d_shift + l.d_r_d_plane(2) * s.plane.normal_W().x() == Approx(0.0).margin(1e-9));
}

TEST_CASE("co-planarity: the robust loss caps the pull of a far point", "[coplanarity]") {
    const Scene s;
    const HuberLoss loss{1.5};
    const CoplanarityLinearization l = linearize(s.plane, s.plane, s.host, s.point, loss);
    REQUIRE(std::abs(linearize(s.plane, s.plane, s.host, s.point).r) > 5.0);
    CHECK(l.weight == Approx(1.5 / std::abs(linearize(s.plane, s.plane, s.host, s.point).r)));
    CHECK(std::abs(l.d_r_d_plane(2) * l.r) == Approx(1.5 / kSigma));  // gradient of Huber's loss
}

TEST_CASE("co-planarity: a point at infinity is refused", "[coplanarity]") {
    Scene s;
    s.point.rho = 0.0;
    CoplanarityLinearization l;
    CHECK(linearize_coplanarity(s.plane, s.plane, s.host, s.point, kSigma, kNoLoss, l) == Status::kDegenerate);
}

}  // namespace facet::coplanarity_factor_test
