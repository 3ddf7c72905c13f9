// SPDX-License-Identifier: BSD-2-Clause
// Relative views, planes in a chart, and the 3x3 Cholesky factor, against the long way round.
#include "estimator/geometry/relative_view.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "estimator/geometry/cholesky3.h"
#include "estimator/geometry/plane_chart.h"
#include "tests/support/numeric_jacobian.h"

namespace facet::relative_view_test {
namespace {

const CameraPose kHost = CameraPose::from(Se3{so3_exp({0.2, -0.4, 0.7}), {0.3, 1.2, -0.5}});
const CameraPose kCamera = CameraPose::from(Se3{so3_exp({0.3, -0.5, 0.6}), {0.5, 1.0, -0.3}});

}  // namespace

TEST_CASE("a relative view sees what the world frame shows, near and at infinity", "[relative_view]") {
    const RelativeView view = RelativeView::of(kCamera, kHost);
    for (const double rho : {2.0, 0.3, 0.0}) {
        const InverseDepthPoint point{{0.1, -0.2}, rho};
        const Eigen::Vector3d expected = kCamera.R_C_W * ScaledWorldPoint(kHost, point).from(kCamera.p_W_C);
        CHECK(view.sight_line(point).isApprox(expected, 1e-12));
        const auto image = [&](const Eigen::Vector3d& d) -> Eigen::Vector2d {
            return view.sight_line({point.xy + d.head<2>(), point.rho + d.z()}).hnormalized();
        };
        const Eigen::Vector2d xy = image(Eigen::Vector3d::Zero());
        test::expect_jacobian_near((view.d_image_d_point_times_z(xy) / expected.z()).eval(), image,
                                   Eigen::Vector3d::Zero().eval());
    }
    CHECK(RelativeView::of(kHost, kHost).T_C_H.isIdentity(1e-12));
}

TEST_CASE("in front means within 87 degrees of the optical axis", "[relative_view]") {
    CHECK(is_in_front({0.0, 0.0, 1e-9}));
    CHECK(is_in_front({1.0, 0.0, 0.06}));
    CHECK_FALSE(is_in_front({1.0, 0.0, 0.04}));
    CHECK_FALSE(is_in_front({0.0, 0.0, -1.0}));
    CHECK_FALSE(is_in_front({0.0, 0.0, 0.0}));
    CHECK_FALSE(is_in_front({0.0, 0.0, std::nan("")}));
}

TEST_CASE("a plane's height in a chart is its height in the world", "[plane_chart]") {
    const Plane plane = Plane::from(Eigen::Vector3d(0.2, 0.1, -0.9).normalized(), -2.0, {0.5, 1.0, 2.0});
    const PlaneChart chart(plane, kHost);
    const InverseDepthPoint point{{0.15, -0.1}, 0.4};
    CHECK(chart.height(point) == Approx(plane.height(ScaledWorldPoint(kHost, point).p_W())));
    test::expect_jacobian_near(
        chart.d_height_d_point(point),
        [&](const Eigen::Vector3d& d) {
            return Eigen::Matrix<double, 1, 1>(chart.height({point.xy + d.head<2>(), point.rho + d.z()}));
        },
        Eigen::Vector3d::Zero().eval());
}

TEST_CASE("the 3x3 Cholesky factor solves and whitens; indefinite and non-finite matrices are refused", "[cholesky3]") {
    Eigen::Matrix3d root;
    root << 2.0, 0.3, -1.0, 0.1, 1.5, 0.4, -0.2, 0.6, 0.8;
    const Eigen::Matrix3d h = root * root.transpose();
    const Eigen::Vector3d b(0.3, -1.0, 2.0);
    Cholesky3 cholesky;
    REQUIRE(ok(cholesky.factorize(h)));
    CHECK(cholesky.solve(b).isApprox(h.inverse() * b, 1e-12));
    CHECK(cholesky.whiten(b).squaredNorm() == Approx(b.dot(h.inverse() * b)));
    Eigen::Matrix<double, 2, 3> rows;
    rows << b.transpose(), 1.0, 2.0, 3.0;
    const Eigen::Matrix2d expected = rows * h.inverse() * rows.transpose();
    cholesky.whiten_rows(rows);
    CHECK((rows * rows.transpose()).isApprox(expected, 1e-12));

    Eigen::Matrix3d bad = h;
    bad(2, 2) = 0.0;
    CHECK(cholesky.factorize(bad) == Status::kDegenerate);
    bad(2, 2) = std::nan("");
    CHECK(cholesky.factorize(bad) == Status::kDegenerate);
    CHECK(cholesky.factorize(Eigen::Matrix3d::Zero()) == Status::kDegenerate);
}

}  // namespace facet::relative_view_test
