// SPDX-License-Identifier: BSD-2-Clause
// Levenberg-Marquardt on a small curved problem: convergence, rejection of bad steps, bounded work, failure.
#include "estimator/solver/levenberg.h"

#include <catch2/catch.hpp>
#include <memory>

namespace facet::levenberg_test {
namespace {

/// Rosenbrock's valley in the first two parameters of one keyframe, a bowl in the others. Minimum 0 at (1, 1, 0, ...).
class Valley {
public:
    explicit Valley(double x, double y) {
        x_.setConstant(0.5);
        x_(0) = x;
        x_(1) = y;
    }
    double linearize(ReducedSystem& system) {
        ++linearizations;
        system.reset(1);
        return fill(system);
    }
    double linearize_gradient(ReducedSystem& system) {
        ++gradients;
        system.reset_gradient(1);
        return fill(system);
    }
    Status solve(ReducedSolver& solver, const ReducedSystem& system, double lambda) {
        return fail_solves ? Status::kDegenerate : solver.solve(system, lambda);
    }
    Status solve_again(ReducedSolver& solver, const ReducedSystem& system) { return solver.solve_again(system); }
    void save() { saved_ = x_; }
    void apply(const ReducedSolver::Step& step) {
        x_ = saved_ + step;
        is_refused_ = false;
    }
    bool last_is_refused() const { return is_refused_; }
    void restore() {
        x_ = saved_;
        is_refused_ = true;
    }

    const Eigen::Matrix<double, kStateDim, 1>& x() const { return x_; }
    int linearizations = 0;
    int gradients = 0;
    bool fail_solves = false;

private:
    double fill(ReducedSystem& system) {
        Eigen::Matrix<double, kStateDim, 1> r = x_;
        r(0) = 10.0 * (x_(1) - x_(0) * x_(0));
        r(1) = 1.0 - x_(0);
        Eigen::Matrix<double, kStateDim, kStateDim> j = Eigen::Matrix<double, kStateDim, kStateDim>::Identity();
        j(0, 0) = -20.0 * x_(0);
        j(0, 1) = 10.0;
        j(1, 0) = -1.0;
        j(1, 1) = 0.0;
        if (system.has_matrix()) {
            system.add_state_block(0, 0, j.transpose() * j);
        }
        system.add_state_gradient(0, j.transpose() * r);
        return 0.5 * r.squaredNorm();
    }

    Eigen::Matrix<double, kStateDim, 1> x_;
    Eigen::Matrix<double, kStateDim, 1> saved_;
    bool is_refused_ = false;
};

/// Nothing ends it before, but the minimum.
LevenbergOptions steps_at_most(int budget, bool trusts_first) {
    LevenbergOptions options;
    options.trusts_first = trusts_first;
    options.max_iterations = budget;
    options.least_decrease = 0.0;
    return options;
}

}  // namespace

TEST_CASE("levenberg reaches the minimum of a curved valley, never going uphill", "[levenberg]") {
    const auto workspace = std::make_unique<LevenbergWorkspace>();
    Valley valley(-1.2, 1.0);
    LevenbergOptions options;
    options.max_iterations = 100;
    options.least_decrease = 1e-14;
    int current = 0;
    const LevenbergSummary summary = levenberg(valley, options, *workspace, current);
    CHECK(valley.x()(0) == Approx(1.0).margin(1e-5));
    CHECK(valley.x()(1) == Approx(1.0).margin(1e-5));
    CHECK(summary.final_cost < 1e-10);
    CHECK(summary.final_cost < summary.initial_cost);
    CHECK_FALSE(summary.solver_failed);
    // The system handed back is the one at the final states: its gradient vanishes there.
    CHECK(Eigen::VectorXd(workspace->systems[current].g()).norm() < 1e-4);
}

TEST_CASE("levenberg leaves the states at the best point when the budget ends", "[levenberg]") {
    const auto workspace = std::make_unique<LevenbergWorkspace>();
    const bool trusts_first = GENERATE(false, true);
    for (int budget = 1; budget <= 6; ++budget) {
        Valley valley(-1.2, 1.0);
        int current = 0;
        const LevenbergSummary summary = levenberg(valley, steps_at_most(budget, trusts_first), *workspace, current);
        CHECK(summary.iterations <= budget);
        CHECK(valley.linearizations + valley.gradients <= budget + 1);
        const auto at_end = std::make_unique<ReducedSystem>();
        CHECK(valley.linearize(*at_end) == Approx(summary.final_cost));
        CHECK((Eigen::VectorXd(at_end->g()) - Eigen::VectorXd(workspace->systems[current].g())).norm() < 1e-12);
    }
}

TEST_CASE("levenberg says so when no system can be solved, and moves nothing", "[levenberg]") {
    const auto workspace = std::make_unique<LevenbergWorkspace>();
    Valley valley(-1.2, 1.0);
    valley.fail_solves = true;
    int current = 0;
    const LevenbergSummary summary = levenberg(valley, {}, *workspace, current);
    CHECK(summary.solver_failed);
    CHECK(valley.x()(0) == -1.2);
    CHECK(summary.final_cost == summary.initial_cost);
}

TEST_CASE("levenberg keeps a matrix that predicts well, and reaches the same minimum", "[levenberg]") {
    const auto workspace = std::make_unique<LevenbergWorkspace>();
    LevenbergOptions options;
    options.max_iterations = 60;
    options.least_decrease = 1e-13;
    int current = 0;
    // GIVEN a start from where the model is nearly right
    Valley exact(1.02, 1.04);
    LevenbergOptions anew = options;
    anew.trusted_gain = 1e9;
    const LevenbergSummary reference = levenberg(exact, anew, *workspace, current);
    CHECK(exact.gradients == 0);
    CHECK(reference.systems == exact.linearizations);
    // WHEN its matrix may be kept THEN fewer are made, the minimum is the same, and the factor is one of them
    Valley kept(1.02, 1.04);
    const LevenbergSummary summary = levenberg(kept, options, *workspace, current);
    CHECK(kept.gradients >= 1);
    CHECK(summary.systems == kept.linearizations);
    CHECK(summary.systems < reference.systems);
    CHECK(summary.is_factorized);
    CHECK((kept.x() - exact.x()).norm() < 1e-5);
    CHECK(Eigen::VectorXd(workspace->systems[current].g()).norm() < 1e-4);
}

TEST_CASE("levenberg keeps the first matrix of a good start, if that is trusted", "[levenberg]") {
    const auto workspace = std::make_unique<LevenbergWorkspace>();
    LevenbergOptions options;
    options.max_iterations = 60;
    options.least_decrease = 1e-13;
    int current = 0;
    Valley usual(1.002, 1.004);
    CHECK(levenberg(usual, options, *workspace, current).systems == 2);
    Valley trusting(1.002, 1.004);
    options.trusts_first = true;
    const LevenbergSummary summary = levenberg(trusting, options, *workspace, current);
    CHECK(summary.systems == 1);
    CHECK(trusting.linearizations == 1);
    CHECK(summary.is_factorized);
    CHECK((trusting.x() - usual.x()).norm() < 1e-5);
    CHECK(Eigen::VectorXd(workspace->systems[current].g()).norm() < 1e-4);
}

TEST_CASE("levenberg makes a new matrix where the first one was trusted in vain", "[levenberg]") {
    const auto workspace = std::make_unique<LevenbergWorkspace>();
    Valley valley(-1.2, 1.0);
    LevenbergOptions options;
    options.max_iterations = 100;
    options.least_decrease = 1e-14;
    options.trusts_first = true;
    int current = 0;
    const LevenbergSummary summary = levenberg(valley, options, *workspace, current);
    CHECK(summary.systems > 1);
    CHECK(valley.x()(0) == Approx(1.0).margin(1e-5));
    CHECK(valley.x()(1) == Approx(1.0).margin(1e-5));
}

TEST_CASE("levenberg says where the matrix of the final states is, whatever ends it", "[levenberg]") {
    const auto workspace = std::make_unique<LevenbergWorkspace>();
    const auto at_end = std::make_unique<ReducedSystem>();
    const bool trusts_first = GENERATE(false, true);
    int refused = 0;
    for (int budget = 1; budget <= 30; ++budget) {
        Valley valley(-1.2, 1.0);
        int current = 0;
        const LevenbergSummary summary = levenberg(valley, steps_at_most(budget, trusts_first), *workspace, current);
        refused += valley.last_is_refused() ? 1 : 0;
        valley.linearize(*at_end);
        CHECK((Eigen::VectorXd(at_end->g()) - Eigen::VectorXd(workspace->systems[current].g())).norm() < 1e-12);
        if (!summary.is_factorized) {
            const Eigen::MatrixXd difference = at_end->h() - workspace->systems[summary.matrix].h();
            CHECK(Eigen::MatrixXd(difference.triangularView<Eigen::Lower>()).norm() < 1e-12);
        }
    }
    CHECK(refused > 0);  // some budgets end with a step that is taken back
}

}  // namespace facet::levenberg_test
