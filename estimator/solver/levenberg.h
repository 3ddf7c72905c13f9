// SPDX-License-Identifier: BSD-2-Clause
// Levenberg-Marquardt over any problem that can linearize itself into a reduced system.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/solver/reduced_system.h"

namespace facet {

struct LevenbergOptions {
    int max_iterations = 6;      ///< solver steps tried, and matrices made again in between: bounds the time
    double first_lambda = 4e-7;  ///< damping relative to the diagonal once a step has failed; 0 before
    /// Stop when a step gains, or promises, less than this. The cost is half a sum of squares in standard deviations: a
    /// decrease d moves no parameter, and no combination of them, by more than sqrt(2 d) of its own. What the prior
    /// leaves out of the cost is arbitrary, so that a share of the cost would be arbitrary as well.
    double least_decrease = 0.1;
    double min_step = 1e-7;  ///< stop when no parameter moves more than this
    /// A matrix whose model promised no more than a step gained, but for this share, is good for the next steps too:
    /// they cost a gradient and a substitution instead of a system and its factor. Above 1: a new matrix at each step.
    double trusted_gain = 0.75;
    bool trusts_first = false;  ///< the start is so good that the first matrix may serve more than one step, too
};

struct LevenbergSummary {
    int iterations = 0;
    double initial_cost = 0.0;
    double final_cost = 0.0;
    bool solver_failed = false;  ///< no positive definite system at any damping tried
    int systems = 0;             ///< linearized in full
    int matrix = 0;              ///< the workspace's system that holds the matrix of the last states that have one
    bool is_factorized = false;  ///< the solver holds its factor, undamped
};

/// The two systems that iterations alternate between, and the solver. Several MB: lives in the window.
struct LevenbergWorkspace {
    ReducedSystem systems[2];
    ReducedSolver solver;
};

/// Minimises problem by Levenberg-Marquardt with diagonal scaling [Marquardt63], [Nielsen99] for lambda.
/// Problem: double linearize(ReducedSystem&)  cost at the current states, fills the system
///          double linearize_gradient(ReducedSystem&)  the same without the matrix
///          Status solve(ReducedSolver&, const ReducedSystem&, lambda)  solver.solve(), so that it can be timed
///          Status solve_again(ReducedSolver&, const ReducedSystem&)  solver.solve_again(), likewise
///          void   save()                     remembers the current states
///          void   apply(step)                states = saved states (+) step
///          void   restore()                  states = saved states
/// Each iteration costs one linearization and one solve: a candidate is judged by linearizing there, and if it is
/// accepted, that linearization serves the next iteration. A step whose quadratic model promises next to nothing is not
/// taken; most optimizations end this way. While steps gain what the model promises, its matrix is kept and only the
/// gradient is computed again (the chord method, [Kelley95] Sec. 5.4.1): the minimum is the same, as the gradient is
/// exact. With a robust loss steps gain more than promised, since weights overrate its curvature; a new matrix would
/// overrate it as well.
/// At the end `workspace.systems[current]` holds the gradient at the final states, and the summary says where the
/// matrix is: at the final states if !is_factorized. At most max_iterations steps, and one linearization more, two if
/// the last step's takes the matrix with it: a system in place of a matrix that was kept too long counts as a step. No
/// heap.
template <class Problem>
LevenbergSummary levenberg(Problem& problem, const LevenbergOptions& options, LevenbergWorkspace& workspace,
                           int& current) {
    current = 0;
    LevenbergSummary summary;
    double lambda = 0.0;
    double growth = 4.0;
    bool has_matrix = true;                  // the current system, not only its gradient
    bool is_trusted = options.trusts_first;  // the matrix may serve once more
    const auto linearize_in_full = [&](int into) {
        ++summary.systems;
        return problem.linearize(workspace.systems[into]);
    };
    const auto solve = [&] {
        return has_matrix ? problem.solve(workspace.solver, workspace.systems[current], lambda)
                          : problem.solve_again(workspace.solver, workspace.systems[current]);
    };
    // After a failure: with a new matrix if it is not of these states, otherwise more cautiously.
    // @return false if the matrix is not of these states, and no step is left for a new one
    const auto retreat = [&](bool is_matrix_lost) {
        is_trusted = false;
        if (has_matrix) {
            lambda = std::max(lambda * growth, options.first_lambda);
            growth *= 4.0;
            return true;
        }
        if (!is_matrix_lost && summary.iterations + 1 >= options.max_iterations) {
            return false;
        }
        summary.iterations = std::min(summary.iterations + 1, options.max_iterations);
        linearize_in_full(current);
        summary.matrix = current;
        has_matrix = true;
        return true;
    };
    summary.initial_cost = summary.final_cost = linearize_in_full(current);
    while (summary.iterations < options.max_iterations) {
        ++summary.iterations;
        summary.solver_failed = !ok(solve());
        if (summary.solver_failed) {
            if (!retreat(false)) {
                break;
            }
            continue;
        }
        if (lambda == 0.0 && workspace.solver.predicted_decrease() <= options.least_decrease) {
            summary.is_factorized = true;
            return summary;
        }
        const double largest = workspace.solver.step().cwiseAbs().maxCoeff();
        problem.save();
        problem.apply(workspace.solver.step());
        const bool keeps_matrix = is_trusted && lambda == 0.0;
        const double cost =
            keeps_matrix ? problem.linearize_gradient(workspace.systems[1 - current]) : linearize_in_full(1 - current);
        const double gain = summary.final_cost - cost;
        if (!(gain >= 0.0) || !std::isfinite(cost)) {
            problem.restore();
            // The candidate's system may have taken the place of the only matrix there was.
            const bool is_matrix_lost = !keeps_matrix && summary.matrix == 1 - current;
            if ((largest < options.min_step && !is_matrix_lost) || !retreat(is_matrix_lost)) {
                break;
            }
            continue;
        }
        current = 1 - current;
        has_matrix = !keeps_matrix;
        if (has_matrix) {
            summary.matrix = current;
        }
        const double ratio = gain / std::max(workspace.solver.predicted_decrease(), 1e-12);
        is_trusted = ratio >= options.trusted_gain;
        lambda *= std::max(0.1, 1.0 - std::pow(2.0 * std::min(ratio, 1.0) - 1.0, 3));
        growth = 4.0;
        const bool converged = gain <= options.least_decrease || largest < options.min_step;
        summary.final_cost = cost;
        if (converged) {
            break;
        }
    }
    summary.is_factorized = !has_matrix;
    return summary;
}

}  // namespace facet
