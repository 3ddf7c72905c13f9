// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/ground_factor.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/support/numeric_jacobian.h"

namespace facet::ground_factor_test {
namespace {

using Vector1 = Eigen::Matrix<double, 1, 1>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector15 = Eigen::Matrix<double, kStateDim, 1>;

NavState random_pose(std::mt19937& generator) {
    std::normal_distribution<double> normal(0.0, 0.5);
    return NavState{}.box_plus(Vector15::NullaryExpr([&] { return normal(generator); }));
}

const Eigen::Vector3d kGround_B(0.2, -0.1, -1.6);

}  // namespace

TEST_CASE("height of the ground: the Jacobian matches central differences", "[ground_factor]") {
    std::mt19937 generator(GENERATE(1U, 2U, 3U));
    const NavState state = random_pose(generator);
    const auto height = [&](const Vector6& d) -> Vector1 {
        Vector15 all = Vector15::Zero();
        all.head<6>() = d;
        const NavState moved = state.box_plus(all);
        return Vector1(linearize_ground_height(moved, moved, kGround_B).height_m);
    };
    const auto jacobian = linearize_ground_height(state, state, kGround_B).d_height_d_pose;
    test::expect_jacobian_near(jacobian, height, Vector6::Zero().eval(), 1e-7);
}

TEST_CASE("height of the ground: a tilted beam is longer over the same ground", "[ground_factor]") {
    NavState state;
    state.p_W_B.z() = 1.5;
    state.q_W_B = so3_exp({0.4, 0.0, 0.0});
    const Eigen::Vector3d beam_B(0.0, 0.0, -1.5 / std::cos(0.4));
    CHECK(linearize_ground_height(state, state, beam_B).height_m == Approx(0.0).margin(1e-12));
}

TEST_CASE("height of the ground: neither yaw nor a step sideways matters, at any first estimate", "[ground_factor]") {
    std::mt19937 generator(4);
    const NavState state = random_pose(generator);
    const NavState lin = random_pose(generator);
    const auto jacobian = linearize_ground_height(state, lin, kGround_B).d_height_d_pose;
    const Eigen::Vector3d yaw_B = lin.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    CHECK(std::abs(jacobian.head<3>() * yaw_B) < 1e-12);
    CHECK(jacobian(3) == 0.0);
    CHECK(jacobian(4) == 0.0);
    CHECK(linearize_ground_height(state, lin, kGround_B).height_m ==
          linearize_ground_height(state, state, kGround_B).height_m);
}

}  // namespace facet::ground_factor_test
