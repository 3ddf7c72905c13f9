// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/values/stereo_depth.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/synthetic_flight.h"

namespace facet::stereo_depth_test {
namespace {

/// The inverse depth in C0 of the point whose pixels a rig sees: that whose right image is nearest.
double inverse_depth(const StereoRig& rig, const Eigen::Vector2d& left_uv, const Eigen::Vector2d& right_uv) {
    Eigen::Vector2d left;
    Eigen::Vector2d right;
    REQUIRE(ok(rig.left.unproject(left_uv, left)));
    REQUIRE(ok(rig.right.unproject(right_uv, right)));
    const Se3 T_C1_C0 = rig.T_C1_C0();
    const auto image = [&](double rho) {
        return Eigen::Vector2d((T_C1_C0.q * left.homogeneous() + rho * T_C1_C0.p).hnormalized());
    };
    double rho = 0.3;
    for (int i = 0; i < 10; ++i) {
        const Eigen::Vector2d line = (image(rho + 1e-6) - image(rho - 1e-6)) / 2e-6;
        rho -= line.dot(image(rho) - right) / line.squaredNorm();
    }
    return rho;
}

TEST_CASE("inverse depth follows the right camera's pose as its derivative says") {
    const StereoRig rig = test::make_rig();
    const Eigen::Vector3d p_C0(0.3, -0.2, 3.0);
    Eigen::Vector2d left;
    Eigen::Vector2d right;
    REQUIRE(ok(rig.left.project(p_C0, left)));
    REQUIRE(ok(rig.right.project(rig.T_C1_C0() * p_C0, right)));
    const CamerasRow d = d_inverse_depth_d_cameras(p_C0, rig);
    for (int axis = 0; axis < 3; ++axis) {
        for (const bool is_turn : {true, false}) {
            constexpr double kStep = 1e-5;
            StereoRig moved = rig;
            const Eigen::Vector3d by = kStep * Eigen::Vector3d::Unit(axis);
            if (is_turn) {
                moved.T_B_C1.q = rig.T_B_C1.q * so3_exp(by);
            } else {
                moved.T_B_C1.p += by;
            }
            const double change = (inverse_depth(moved, left, right) - inverse_depth(rig, left, right)) / kStep;
            CHECK(d[kLensDim + (is_turn ? 0 : 3) + axis] == Approx(change).margin(2e-3));
        }
    }
}

TEST_CASE("a turn of the right camera offsets inverse depths by the angle over the baseline") {
    const StereoRig rig = test::make_rig();
    CameraCorrections cameras;
    CHECK(inverse_depth_sigma(3.0, rig, cameras) == 0.0);
    cameras.covariance(kLensDim + 1, kLensDim + 1) = 1e-6;  // 1 mrad about y
    const double near = inverse_depth_sigma(2.0, rig, cameras);
    CHECK(near == Approx(1e-3 / rig.baseline_m()).epsilon(0.1));
    CHECK(inverse_depth_sigma(5.0, rig, cameras) == Approx(near).epsilon(0.05));
    StereoRig one = rig;
    one.has_right = false;
    CHECK(inverse_depth_sigma(3.0, one, cameras) == 0.0);
}

}  // namespace
}  // namespace facet::stereo_depth_test
