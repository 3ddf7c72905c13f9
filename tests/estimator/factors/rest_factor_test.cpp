// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/rest_factor.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/support/numeric_jacobian.h"

namespace facet::rest_factor_test {
namespace {

using Vector15 = Eigen::Matrix<double, kStateDim, 1>;

NavState random_state(std::mt19937& generator, double spread) {
    std::normal_distribution<double> normal(0.0, spread);
    NavState state;
    return state.box_plus(Vector15::NullaryExpr([&] { return normal(generator); }));
}

RestFactorLinearization linearize(const NavState& i, const NavState& j) {
    RestFactorLinearization l;
    linearize_rest(i, j, i, j, RestSigmas{}, l);
    return l;
}

}  // namespace

TEST_CASE("rest factor: Jacobians match central differences", "[rest_factor]") {
    std::mt19937 generator(GENERATE(1U, 2U, 3U));
    const NavState i = random_state(generator, 0.5);
    const NavState j = random_state(generator, 0.5);
    const RestFactorLinearization l = linearize(i, j);
    test::expect_jacobian_near(
        l.d_r_d_i, [&](const Vector15& d) { return linearize(i.box_plus(d), j).r; }, Vector15::Zero().eval(), 1e-6);
    test::expect_jacobian_near(
        l.d_r_d_j, [&](const Vector15& d) { return linearize(i, j.box_plus(d)).r; }, Vector15::Zero().eval(), 1e-6);
}

TEST_CASE("rest factor: nothing to say about a vehicle at rest, wherever it is", "[rest_factor]") {
    std::mt19937 generator(4);
    NavState i = random_state(generator, 1.0);
    i.v_W_B.setZero();
    CHECK(linearize(i, i).r.norm() < 1e-9);
    NavState moved = i;
    moved.p_W_B.x() += 2e-3;
    CHECK(linearize(i, moved).r.norm() == Approx(1.0));  // one standard deviation
}

TEST_CASE("rest factor takes Jacobians at the first estimates", "[rest_factor]") {
    std::mt19937 generator(5);
    const NavState i = random_state(generator, 0.3);
    const NavState j = random_state(generator, 0.3);
    const NavState i_lin = random_state(generator, 0.3);
    RestFactorLinearization mixed;
    linearize_rest(i, j, i_lin, j, RestSigmas{}, mixed);
    CHECK(mixed.r.isApprox(linearize(i, j).r));
    CHECK(mixed.d_r_d_i.isApprox(linearize(i_lin, j).d_r_d_i));
}

}  // namespace facet::rest_factor_test
