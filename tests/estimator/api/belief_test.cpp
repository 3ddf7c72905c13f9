// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/belief.h"

#include <catch2/catch.hpp>

#include "estimator/geometry/so3.h"

namespace facet::belief_test {

using Catch::Matchers::WithinAbs;

namespace {

double yaw_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
    const Eigen::Matrix3d R = (b * a.conjugate()).toRotationMatrix();
    return std::atan2(R(1, 0), R(0, 0));
}

}  // namespace

TEST_CASE("a belief turned to another one's yaw keeps tilt, place, speed and what is known of them") {
    Belief belief;
    belief.state.q_W_B = so3_exp({0.3, -0.4, 0.9});
    belief.state.p_W_B = {1.0, 2.0, 3.0};
    belief.state.v_W_B = {0.5, -0.2, 0.1};
    const StateCovariance root = StateCovariance::Random();
    belief.covariance = root * root.transpose();
    const Eigen::Quaterniond tilted = so3_exp({0.02, 0.01, 0.0}) * belief.state.q_W_B;  // gravity seen otherwise
    const Eigen::Quaterniond wanted = so3_exp({0.0, 0.0, -1.2}) * tilted;
    const Belief before = belief;
    turn_to_yaw_of(wanted, belief);

    CHECK_THAT(yaw_between(belief.state.q_W_B, wanted), WithinAbs(0.0, 5e-4));  // second order in the tilt
    CHECK_THAT(yaw_between(before.state.q_W_B, belief.state.q_W_B), WithinAbs(-1.2, 5e-4));
    const auto up_B = [](const Belief& b) -> Eigen::Vector3d {
        return b.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    };
    CHECK((up_B(belief) - up_B(before)).norm() < 1e-12);
    CHECK((belief.state.p_W_B - before.state.p_W_B).norm() == 0.0);
    const auto v_B = [](const Belief& b) -> Eigen::Vector3d { return b.state.q_W_B.conjugate() * b.state.v_W_B; };
    CHECK((v_B(belief) - v_B(before)).norm() < 1e-12);
    // The same, of the covariance: seen from the body nothing has changed.
    const auto in_body = [](const Belief& b) {
        StateCovariance J = StateCovariance::Identity();
        J.block<3, 3>(kPos, kPos) = b.state.q_W_B.toRotationMatrix().transpose();
        J.block<3, 3>(kVel, kVel) = b.state.q_W_B.toRotationMatrix().transpose();
        return StateCovariance(J * b.covariance * J.transpose());
    };
    CHECK((in_body(belief) - in_body(before)).norm() < 1e-9);
}

TEST_CASE("what is not known of the heading alone makes the velocity no less certain") {
    Belief belief;
    belief.state.q_W_B = so3_exp({0.3, -0.4, 0.9});
    belief.state.v_W_B = {3.0, -4.0, 0.5};
    // An error of the yaw of 0.5 rad, which turns the velocity with it; and 0.02 m/s of another origin.
    Eigen::Matrix<double, kStateDim, 1> yaw = Eigen::Matrix<double, kStateDim, 1>::Zero();
    yaw.segment<3>(kTheta) = belief.state.q_W_B.conjugate() * Eigen::Vector3d(0.0, 0.0, 0.5);
    yaw.segment<3>(kVel) = 0.5 * Eigen::Vector3d::UnitZ().cross(belief.state.v_W_B);
    belief.covariance = yaw * yaw.transpose();
    belief.covariance(kVel, kVel) += 0.02 * 0.02;
    CHECK_THAT(velocity_sigma(belief), WithinAbs(0.02, 1e-9));
    belief.covariance(kTheta, kTheta) += 0.01;  // of the attitude, without the velocity's
    CHECK(velocity_sigma(belief) > 0.1);
}

}  // namespace facet::belief_test
