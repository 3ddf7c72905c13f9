// SPDX-License-Identifier: BSD-2-Clause
// Marginalization: the prior it leaves gives the rest the same optimum and information as the full problem had.
#include "estimator/window/marginalization.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <random>

namespace facet::marginalization_test {
namespace {

Eigen::MatrixXd random_matrix(int rows, int cols, std::mt19937& generator) {
    std::normal_distribution<double> normal;
    return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return normal(generator); });
}

}  // namespace

TEST_CASE("the prior has the Schur complement's information and minimum", "[marginalization]") {
    std::mt19937 generator(5);
    constexpr int kKeyframes = 4;
    const int globals = GENERATE(0, 1, 7);
    const int leaving = GENERATE(0, 2, 3);
    const int rest = globals + (kKeyframes - 1) * kStateDim;
    const auto system = std::make_unique<ReducedSystem>();
    const auto prior = std::make_unique<PriorFactor>();
    system->reset(kKeyframes, globals);
    const Eigen::MatrixXd j = random_matrix(100, system->dim(), generator);
    const Eigen::MatrixXd h = j.transpose() * j;
    const Eigen::VectorXd g = random_matrix(system->dim(), 1, generator);
    system->h() = h.triangularView<Eigen::Lower>();
    system->g() = g;
    const Eigen::VectorXd displacement = 0.1 * random_matrix(rest, 1, generator);
    REQUIRE(ok(marginalize_keyframe(*system, leaving, displacement, *prior)));
    CHECK(prior->globals() == globals);
    CHECK(prior->keyframes() == kKeyframes - 1);

    // What stays, in order: rows before and after the keyframe that left.
    Eigen::MatrixXd keep = Eigen::MatrixXd::Zero(rest, system->dim());
    const int at = system->offset(leaving);
    keep.topLeftCorner(at, at).setIdentity();
    keep.bottomRightCorner(rest - at, rest - at).setIdentity();

    // Information of the rest is the inverse of their block of the full covariance.
    const Eigen::MatrixXd information = (keep * h.inverse() * keep.transpose()).inverse();
    CHECK((Eigen::MatrixXd(prior->h()) - information).cwiseAbs().maxCoeff() < 1e-8 * information.cwiseAbs().maxCoeff());

    // The optimum of the full problem, relative to the current states, is that of the prior, relative to the
    // linearization points.
    const Eigen::VectorXd optimum = keep * h.ldlt().solve(-g);
    const Eigen::VectorXd d = displacement + optimum;
    Eigen::VectorXd gradient(rest);
    const double cost = prior->evaluate(d, gradient);
    CHECK(gradient.norm() < 1e-8);
    const Eigen::VectorXd beside = d + 0.01 * random_matrix(rest, 1, generator);
    CHECK(prior->evaluate(beside, gradient) > cost);
}

TEST_CASE("marginalization refuses an undetermined keyframe and leaves the prior alone", "[marginalization]") {
    const auto system = std::make_unique<ReducedSystem>();
    const auto prior = std::make_unique<PriorFactor>();
    system->reset(2);
    prior->reset(1);
    prior->h().setIdentity();
    const Eigen::VectorXd displacement = Eigen::VectorXd::Zero(kStateDim);
    CHECK(marginalize_keyframe(*system, 0, displacement, *prior) == Status::kDegenerate);
    CHECK(prior->h().isIdentity(0.0));
}

TEST_CASE("moving a single-keyframe prior to another linearization point leaves its cost where it was", "[prior]") {
    std::mt19937 generator(9);
    const auto prior = std::make_unique<PriorFactor>();
    prior->reset(1);
    const Eigen::MatrixXd j = random_matrix(20, kStateDim, generator);
    prior->h() = j.transpose() * j;
    prior->g() = random_matrix(kStateDim, 1, generator);
    NavState x_0;
    x_0.q_W_B = so3_exp({0.3, -0.2, 1.0});
    const Eigen::Matrix<double, kStateDim, 1> d = 0.2 * random_matrix(kStateDim, 1, generator);
    const NavState x_1 = x_0.box_plus(d);
    const auto cost = [&](const NavState& lin, const NavState& x) {
        Eigen::VectorXd gradient(kStateDim);
        return prior->evaluate(lin.box_minus_to(x), gradient);
    };
    const Eigen::Matrix<double, kStateDim, 1> small = 1e-4 * random_matrix(kStateDim, 1, generator);
    const double before = cost(x_0, x_1.box_plus(small)) - cost(x_0, x_1);
    prior->rebase_single(d);
    const double after = cost(x_1, x_1.box_plus(small)) - cost(x_1, x_1);
    CHECK(after == Approx(before).epsilon(1e-3));
}

}  // namespace facet::marginalization_test
