// SPDX-License-Identifier: BSD-2-Clause
// Levenberg-Marquardt over any problem that can linearize itself into a reduced system.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/solver/reduced_system.h"

namespace facet {

struct LevenbergOptions {
    int max_iterations = 6;           ///< solver steps tried, accepted or not: bounds the time
    double first_lambda = 4e-7;       ///< damping relative to the diagonal once a step has failed; 0 before
    double relative_decrease = 1e-4;  ///< stop when a step gains, or promises, less than this share of 1 + |cost|
    double min_step = 1e-7;           ///< stop when no parameter moves more than this
};

struct LevenbergSummary {
    int iterations = 0;
    double initial_cost = 0.0;
    double final_cost = 0.0;
    bool solver_failed = false;  ///< no positive definite system at any damping tried
    bool is_factorized = false;  ///< the solver holds the final system's factor, undamped
};

/// The two systems that iterations alternate between, and the solver. Several MB: lives in the window.
struct LevenbergWorkspace {
    ReducedSystem systems[2];
    ReducedSolver solver;
};

/// Minimises problem by Levenberg-Marquardt with diagonal scaling [Marquardt63], [Nielsen99] for lambda.
/// Problem: double linearize(ReducedSystem&)  cost at the current states, fills the system
///          Status solve(ReducedSolver&, const ReducedSystem&, lambda)  solver.solve(), so that it can be timed
///          void   save()                     remembers the current states
///          void   apply(step)                states = saved states (+) step
///          void   restore()                  states = saved states
/// Each iteration costs one linearization and one solve: a candidate is judged by linearizing there, and if it is
/// accepted, that linearization serves the next iteration. A step whose quadratic model promises next to nothing is not
/// taken; most optimizations end this way, with the system and its factor at the final states. At the end
/// `workspace.systems[current]` holds the system at the final states. Bounded by max_iterations. No heap.
template <class Problem>
LevenbergSummary levenberg(Problem& problem, const LevenbergOptions& options, LevenbergWorkspace& workspace,
                           int& current) {
    current = 0;
    LevenbergSummary summary;
    double lambda = 0.0;
    double growth = 4.0;
    const auto raise_lambda = [&] {
        lambda = std::max(lambda * growth, options.first_lambda);
        growth *= 4.0;
    };
    summary.initial_cost = summary.final_cost = problem.linearize(workspace.systems[current]);
    while (summary.iterations < options.max_iterations) {
        ++summary.iterations;
        if (!ok(problem.solve(workspace.solver, workspace.systems[current], lambda))) {
            summary.solver_failed = true;
            raise_lambda();
            continue;
        }
        summary.solver_failed = false;
        const double negligible = options.relative_decrease * (1.0 + std::abs(summary.final_cost));
        if (lambda == 0.0 && workspace.solver.predicted_decrease() <= negligible) {
            summary.is_factorized = true;
            break;
        }
        const double largest = workspace.solver.step().cwiseAbs().maxCoeff();
        problem.save();
        problem.apply(workspace.solver.step());
        const double cost = problem.linearize(workspace.systems[1 - current]);
        const double gain = summary.final_cost - cost;
        if (!(gain >= 0.0) || !std::isfinite(cost)) {
            problem.restore();
            if (largest < options.min_step) {
                break;
            }
            raise_lambda();
            continue;
        }
        current = 1 - current;
        const double ratio = gain / std::max(workspace.solver.predicted_decrease(), 1e-12);
        lambda *= std::max(0.1, 1.0 - std::pow(2.0 * std::min(ratio, 1.0) - 1.0, 3));
        growth = 4.0;
        const bool converged = gain <= negligible || largest < options.min_step;
        summary.final_cost = cost;
        if (converged) {
            break;
        }
    }
    return summary;
}

}  // namespace facet
