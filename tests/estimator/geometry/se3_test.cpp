// SPDX-License-Identifier: BSD-2-Clause
// Invariants of rigid transforms: group laws, matrix form, box operators.
#include "estimator/geometry/se3.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <random>

#include "estimator/geometry/stereo_rig.h"

namespace facet::se3_test {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

Vector6 random6(std::mt19937& rng, double scale) {
    std::uniform_real_distribution<double> uniform(-scale, scale);
    return Vector6::NullaryExpr([&](Eigen::Index) { return uniform(rng); });
}

}  // namespace

TEST_CASE("transforms compose, invert and act as their matrices do") {
    std::mt19937 rng(1);
    for (int trial = 0; trial < 20; ++trial) {
        const Se3 a = Se3{}.box_plus(random6(rng, 2.0));
        const Se3 b = Se3{}.box_plus(random6(rng, 2.0));
        const Eigen::Vector3d x = random6(rng, 5.0).head<3>();
        CHECK(((a * b).matrix() - a.matrix() * b.matrix()).norm() < 1e-13);
        CHECK((a.inverse().matrix() - a.matrix().inverse()).norm() < 1e-13);
        CHECK(((a * b) * x - a * (b * x)).norm() < 1e-13);
        CHECK((a * x - (a.matrix() * x.homogeneous()).head<3>()).norm() < 1e-13);
        CHECK((Se3::from_matrix(a.matrix()).matrix() - a.matrix()).norm() < 1e-13);
        CHECK(std::abs((a * b).q.norm() - 1.0) < 1e-14);
    }
}

TEST_CASE("box_minus_to inverts box_plus") {
    std::mt19937 rng(2);
    for (int trial = 0; trial < 20; ++trial) {
        const Se3 a = Se3{}.box_plus(random6(rng, 2.0));
        const Vector6 d = random6(rng, 1.5);
        CHECK((a.box_minus_to(a.box_plus(d)) - d).norm() < 1e-13);
    }
}

TEST_CASE("the tangent turns on the right and moves in the target frame") {
    const Se3 a{so3_exp(Eigen::Vector3d(0.1, 0.2, 0.3)), Eigen::Vector3d(1.0, 2.0, 3.0)};
    Vector6 d;
    d << 0.0, 0.0, 0.5, 0.1, 0.0, 0.0;
    const Se3 b = a.box_plus(d);
    CHECK((b.R() - a.R() * so3_exp(Eigen::Vector3d(0.0, 0.0, 0.5)).toRotationMatrix()).norm() < 1e-14);
    CHECK((b.p - a.p - Eigen::Vector3d(0.1, 0.0, 0.0)).norm() < 1e-15);
}

TEST_CASE("the rig's right-from-left transform and baseline follow from the extrinsics") {
    StereoRig rig;
    rig.T_B_C0 = {so3_exp(Eigen::Vector3d(0.1, -0.2, 1.5)), Eigen::Vector3d(0.02, 0.0, 0.01)};
    rig.T_B_C1 = rig.T_B_C0 * Se3{so3_exp(Eigen::Vector3d(0.01, 0.0, 0.0)), Eigen::Vector3d(0.11, 0.0, 0.0)};
    const Eigen::Vector3d p_C1(0.3, -0.1, 2.0);
    const Eigen::Vector3d p_C0 = rig.T_B_C0.inverse() * (rig.T_B_C1 * p_C1);
    CHECK((rig.T_C1_C0() * p_C0 - p_C1).norm() < 1e-14);
    CHECK(rig.baseline_m() == Approx(0.11).epsilon(1e-12));
}

}  // namespace facet::se3_test
