// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/pose_difference.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace facet::pose_difference_test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

const Se3 kPose{so3_exp(Vector3d(0.4, -0.9, 1.7)), {1.0, -2.0, 3.0}};

TEST_CASE("a pose differs from itself by nothing, even as the opposite quaternion") {
    Se3 opposite = kPose;
    opposite.q.coeffs() *= -1.0;
    for (const Se3& other : {kPose, opposite}) {
        const PoseDifference d = pose_difference(kPose, other);
        CHECK(d.theta.norm() < 1e-15);
        CHECK(d.p.norm() == 0.0);
    }
}

TEST_CASE("the difference leads from one pose to the other: body axes for the turn, world axes for the shift") {
    const Vector3d theta(0.1, 0.2, -0.3);
    const Vector3d p(0.3, 0.0, -0.4);
    const PoseDifference d = pose_difference(kPose, {kPose.q * so3_exp(theta), kPose.p + p});
    CHECK((d.theta - theta).norm() < 1e-14);
    CHECK((d.p - p).norm() < 1e-14);
    CHECK(d.angle_deg() == Approx(theta.norm() * 57.29577951308232));
    CHECK(d.distance_m() == Approx(0.5));
    const PoseDifference back = pose_difference({kPose.q * so3_exp(theta), kPose.p + p}, kPose);
    CHECK((back.theta + theta).norm() < 1e-14);
    CHECK((back.p + p).norm() < 1e-14);
}

TEST_CASE("the nearest turn about z is found under a tilt and in a sum") {
    const auto turn = [](double yaw) { return Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix(); };
    for (const double yaw : {-3.0, -0.5, 0.0, 1.2, 3.1}) {
        CHECK(nearest_yaw(turn(yaw)) == Approx(yaw).margin(1e-15));
        // A tilt about a horizontal axis of the turned frame does not move it.
        const Eigen::Matrix3d tilt = so3_exp(Vector3d(0.2, 0.1, 0.0)).toRotationMatrix();
        CHECK(nearest_yaw(turn(yaw) * tilt) == Approx(yaw).margin(1e-12));
    }
    CHECK(nearest_yaw(2.0 * turn(0.3) + 2.0 * turn(0.5)) == Approx(0.4));
    CHECK(nearest_yaw(Eigen::Matrix3d::Zero()) == 0.0);
}

}  // namespace
}  // namespace facet::pose_difference_test
