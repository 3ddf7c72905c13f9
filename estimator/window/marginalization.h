// SPDX-License-Identifier: BSD-2-Clause
// Removes the oldest keyframe from the window and keeps its information as a prior on the rest.
#pragma once

#include <array>

#include "estimator/solver/reduced_system.h"
#include "estimator/window/window_problem.h"

namespace facet {

/// Replaces the prior by the Schur complement of `system` (dimension n, all keyframes) with respect to one keyframe m:
///   H' = H_rr - H_rm H_mm^-1 H_mr,  g' = g_r - H_rm H_mm^-1 g_m,
/// then moved from the current states to the linearization points by the remaining parameters' displacements d:
///   g'' = g' - H' d.
/// @param displacement  x_lin.box_minus_to(x) of the globals and the remaining keyframes, stacked
/// @return kDegenerate if H_mm is not positive definite (prior untouched). No heap.
Status marginalize_keyframe(const ReducedSystem& system, int keyframe,
                            const Eigen::Ref<const Eigen::VectorXd>& displacement, PriorFactor& prior);

/// Removes keyframes from a window of two or more. Thread-bound. No heap.
class Marginalizer {
public:
    /// Removes the oldest keyframe. Landmarks it sees whose track has ended go into the prior with all their
    /// observations; of those still tracked at the newest keyframe only the oldest keyframe's observation is dropped,
    /// so that the track stays one landmark. Keyframes in the prior keep their linearization points from here on.
    /// @return kDegenerate if the oldest keyframe is not determined: it is removed all the same, and the prior is empty
    ///         (no keyframe, no globals): the caller must give the window another.
    Status marginalize_oldest(WindowState& state, const WindowCameras& cameras, WindowProblem& problem,
                              ReducedSystem& system);

    /// Removes a keyframe between others: its observations are dropped, its information from inertial data and the
    /// prior goes into the prior, and the next keyframe's inertial factor becomes part of the prior.
    /// @return kDegenerate if the keyframe is not determined (window untouched).
    Status drop_between(int keyframe, WindowState& state, const WindowCameras& cameras, WindowProblem& problem,
                        ReducedSystem& system);

private:
    /// Displacements of the parameters that remain when a keyframe leaves.
    void fill_displacement(const WindowState& state, int leaving, int globals);

    std::array<bool, kMaxLandmarks> selected_;
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSystemDim, 1> displacement_;
};

}  // namespace facet
