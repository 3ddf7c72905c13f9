// SPDX-License-Identifier: BSD-2-Clause
// Reprojection factor: residual, Jacobians against numeric differentiation, first-estimate Jacobians, robust weights.
#include "estimator/factors/stereo_factor.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/support/numeric_jacobian.h"
#include "tests/support/synthetic_flight.h"

namespace facet::stereo_factor_test {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

struct Setup {
    StereoGeometry geometry;
    Se3 T_W_B;
    CameraPose host;
    InverseDepthPoint point;
    StereoMeasurement z;
};

Setup make_setup(unsigned seed, double rho) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto random3 = [&] { return Eigen::Vector3d(uniform(generator), uniform(generator), uniform(generator)); };
    const StereoRig rig = test::make_rig();
    Setup s;
    s.geometry = {rig.T_B_C0.R().transpose(), rig.T_B_C1.R().transpose(), rig.T_B_C0.p, rig.T_B_C1.p, 2.0};
    const Se3 T_W_H{so3_exp(0.5 * random3()), random3()};
    s.host = CameraPose::from(T_W_H * rig.T_B_C0);
    s.T_W_B = T_W_H.box_plus((Vector6() << 0.05 * random3(), 0.3 * random3()).finished());
    s.point = {{0.2 * uniform(generator), 0.2 * uniform(generator)}, rho};
    s.z.left_xy = {0.21 * uniform(generator), 0.1};
    s.z.right_xy = {0.05, 0.1 * uniform(generator)};
    s.z.has_right = true;
    s.z.d_left_d_xy << 200.0F, 10.0F, -15.0F, 190.0F;
    s.z.d_right_d_xy << 210.0F, -20.0F, -15.0F, 220.0F;
    return s;
}

/// The setup's host as seen from a body pose.
StereoView view_from(const Setup& s, const Se3& T_W_B) {
    const Se3 T_B_C0{Eigen::Quaterniond(s.geometry.R_C0_B.transpose()), s.geometry.p_B_C0};
    const Se3 T_B_C1{Eigen::Quaterniond(s.geometry.R_C1_B.transpose()), s.geometry.p_B_C1};
    return {RelativeView::of(CameraPose::from(T_W_B * T_B_C0), s.host),
            RelativeView::of(CameraPose::from(T_W_B * T_B_C1), s.host)};
}

StereoLinearization linearize(const Setup& s, const Se3& at, const Se3& lin, const InverseDepthPoint& point,
                              double huber = 1e9) {
    StereoLinearization l;
    REQUIRE(ok(linearize_stereo(s.z, s.geometry, view_from(s, at), view_from(s, lin), lin.R().transpose(), point,
                                RobustLoss{huber}, nullptr, l)));
    return l;
}

Eigen::Matrix<double, 4, 6> d_r_d_pose(const StereoLinearization& l) {
    return l.d_r_d_T_W_B_transposed.topRows<6>().transpose();
}

}  // namespace

TEST_CASE("stereo factor Jacobians match numeric differentiation", "[stereo_factor]") {
    for (unsigned seed = 1; seed <= 5; ++seed) {
        for (const double rho : {1.0, 0.2, 1e-3, 0.0}) {
            const Setup s = make_setup(seed, rho);
            const StereoLinearization l = linearize(s, s.T_W_B, s.T_W_B, s.point);
            test::expect_jacobian_near(
                d_r_d_pose(l),
                [&](const Vector6& d) {
                    const Se3 T = s.T_W_B.box_plus(d);
                    return linearize(s, T, T, s.point).r;
                },
                Vector6::Zero().eval(), 1e-6);
            test::expect_jacobian_near(
                l.d_r_d_point,
                [&](const Eigen::Vector3d& d) {
                    const InverseDepthPoint p{s.point.xy + d.head<2>(), s.point.rho + d.z()};
                    return linearize(s, s.T_W_B, s.T_W_B, p).r;
                },
                Eigen::Vector3d::Zero().eval(), 1e-6);
        }
    }
}

TEST_CASE("stereo factor Jacobians by single cameras match numeric differentiation", "[stereo_factor]") {
    // Each lens moves the measured point; the right camera turns on its own side and moves in the frame of the pair.
    const Setup s = make_setup(6, 0.4);
    const LensJacobian left = LensJacobian::Random();
    const LensJacobian right = LensJacobian::Random();
    const Se3 T_B_C1{Eigen::Quaterniond(s.geometry.R_C1_B.transpose()), s.geometry.p_B_C1};
    const Eigen::Matrix3d R_B_C1 = T_B_C1.R();
    const CameraTerms terms{left, right, R_B_C1};
    using Parameters = Eigen::Matrix<double, kCameraTermsDim, 1>;
    const auto at = [&](const Parameters& d) {
        Setup moved = s;
        moved.z.left_xy += left.cast<double>() * d.head<kLensDim>();
        moved.z.right_xy += right.cast<double>() * d.tail<kLensDim>();
        moved.geometry.R_C1_B = (T_B_C1.q * so3_exp(d.segment<3>(kLensDim))).toRotationMatrix().transpose();
        moved.geometry.p_B_C1 += d.segment<3>(kLensDim + 3);
        const StereoView view = view_from(moved, s.T_W_B);
        StereoLinearization l;
        REQUIRE(ok(linearize_stereo(moved.z, moved.geometry, view, view, s.T_W_B.R().transpose(), s.point,
                                    RobustLoss{1e9}, &terms, l)));
        return l;
    };
    const StereoLinearization l = at(Parameters::Zero());
    Eigen::Matrix<double, 4, kCameraTermsDim> jacobian = Eigen::Matrix<double, 4, kCameraTermsDim>::Zero();
    jacobian.topLeftCorner<2, kLensDim>() = l.d_r_d_left_lens_transposed.transpose();
    jacobian.bottomRightCorner<2, kRightCameraDim>() =
        l.d_r_d_right_camera_transposed.topRows<kRightCameraDim>().transpose();
    CHECK(l.d_r_d_right_camera_transposed.bottomRows<2>().isZero(0.0));  // padding
    test::expect_jacobian_near(
        jacobian, [&](const Parameters& d) { return at(d).r; }, Parameters::Zero().eval(), 1e-6);
}

TEST_CASE("stereo factor: the gradient without Jacobians is that with them", "[stereo_factor]") {
    const LensJacobian left = LensJacobian::Random();
    const LensJacobian right = LensJacobian::Random();
    const Eigen::Vector4d r(0.3, -1.2, 0.7, 2.1);
    for (const bool has_right : {true, false}) {
        Setup s = make_setup(7, 0.3);
        s.z.has_right = has_right;
        const Eigen::Matrix3d R_B_C1 = s.geometry.R_C1_B.transpose();
        const CameraTerms terms{left, right, R_B_C1};
        const Se3 lin = s.T_W_B.box_plus((Vector6() << 0.01, -0.02, 0.01, 0.05, 0.02, -0.03).finished());
        const Eigen::Matrix3d R_B_W_lin = lin.R().transpose();
        const StereoView view = view_from(s, s.T_W_B);
        const StereoView view_lin = view_from(s, lin);
        const RobustLoss loss{1.5, LossKind::kCauchy};
        StereoLinearization l;
        REQUIRE(ok(linearize_stereo(s.z, s.geometry, view, view_lin, R_B_W_lin, s.point, loss, &terms, l)));
        StereoResidual alone;
        REQUIRE(ok(linearize_point(s.z, s.geometry, view, view_lin, s.point, loss, alone)));
        CHECK(alone.r == l.r);
        CHECK(alone.d_r_d_point == l.d_r_d_point);
        const StereoGradient g = stereo_gradient(alone, r, s.geometry, R_B_W_lin, s.point.rho, &terms);
        CHECK(g.pose.isApprox(l.d_r_d_T_W_B_transposed.topRows<6>() * r, 1e-12));
        CHECK(g.left_lens.isApprox(l.d_r_d_left_lens_transposed * r.head<2>(), 1e-12));
        if (has_right) {
            CHECK(g.right_camera.isApprox(l.d_r_d_right_camera_transposed.topRows<kRightCameraDim>() * r.tail<2>(),
                                          1e-12));
        }
    }
}

TEST_CASE("stereo factor takes residuals at the estimate and Jacobians at the first estimate", "[stereo_factor]") {
    const Setup s = make_setup(3, 0.4);
    const Se3 moved = s.T_W_B.box_plus((Vector6() << 0.01, -0.02, 0.01, 0.05, 0.02, -0.03).finished());
    const StereoLinearization mixed = linearize(s, moved, s.T_W_B, s.point);
    CHECK(mixed.r.isApprox(linearize(s, moved, moved, s.point).r, 1e-12));
    CHECK(d_r_d_pose(mixed).isApprox(d_r_d_pose(linearize(s, s.T_W_B, s.T_W_B, s.point)), 1e-12));
    CHECK_FALSE(d_r_d_pose(mixed).isApprox(d_r_d_pose(linearize(s, moved, moved, s.point)), 1e-6));
    CHECK(mixed.d_r_d_T_W_B_transposed.bottomRows<2>().isZero(0.0));  // padding
}

TEST_CASE("stereo factor: an exact measurement has no residual, a mono one no right rows", "[stereo_factor]") {
    Setup s = make_setup(2, 0.5);
    const ScaledWorldPoint world(s.host, s.point);
    const Eigen::Vector3d q_B = s.T_W_B.R().transpose() * world.from(s.T_W_B.p);
    const Eigen::Vector3d q_0 = s.geometry.R_C0_B * (q_B - s.point.rho * s.geometry.p_B_C0);
    const Eigen::Vector3d q_1 = s.geometry.R_C1_B * (q_B - s.point.rho * s.geometry.p_B_C1);
    s.z.left_xy = q_0.head<2>() / q_0.z();
    s.z.right_xy = q_1.head<2>() / q_1.z();
    CHECK(linearize(s, s.T_W_B, s.T_W_B, s.point).r.norm() < 1e-9);
    s.z.has_right = false;
    const StereoLinearization mono = linearize(s, s.T_W_B, s.T_W_B, s.point);
    CHECK(d_r_d_pose(mono).bottomRows<2>().isZero(0.0));
    CHECK(mono.d_r_d_point.bottomRows<2>().isZero(0.0));
    CHECK(d_r_d_pose(mono).topRows<2>().norm() > 1.0);
}

TEST_CASE("stereo factor: Huber weights scale rows and cap the cost's growth", "[stereo_factor]") {
    const Setup s = make_setup(4, 0.5);
    const StereoLinearization plain = linearize(s, s.T_W_B, s.T_W_B, s.point);
    const StereoLinearization robust = linearize(s, s.T_W_B, s.T_W_B, s.point, 1.5);
    const double norm = plain.r.head<2>().norm();
    REQUIRE(norm > 1.5);
    CHECK(robust.r.head<2>().norm() == Approx(std::sqrt(1.5 / norm) * norm));
    CHECK(RobustLoss{1.5}.cost(robust.squares()) < RobustLoss{1e9}.cost(plain.squares()));
    CHECK(robust.loss.squared_error == Approx(plain.loss.squared_error));
    CHECK(RobustLoss{1e9}.cost(plain.squares()) == Approx(0.5 * plain.loss.squared_error));
}

TEST_CASE("stereo factor refuses points behind a camera", "[stereo_factor]") {
    Setup s = make_setup(5, 1.0);
    const Se3 beyond{s.T_W_B.q, s.host.p_W_C + s.host.R_C_W.transpose() * Eigen::Vector3d(0.0, 0.0, 5.0)};
    StereoLinearization l;
    const StereoView view = view_from(s, beyond);
    CHECK(linearize_stereo(s.z, s.geometry, view, view, beyond.R().transpose(), s.point, RobustLoss{}, nullptr, l) ==
          Status::kDegenerate);
}

}  // namespace facet::stereo_factor_test
