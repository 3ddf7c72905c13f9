// SPDX-License-Identifier: BSD-2-Clause
// Whether the clocks of estimate and ground truth agree.
#pragma once

#include <span>

#include "app/lab/eval/trajectory.h"

namespace facet {

/// Shifts s for which estimate(t) fits truth(t + s) best: positive if the ground truth comes late. Positions and
/// orientations apart, because in many ground truths they are of different instruments with clocks of their own.
struct TimeShift {
    bool is_known = false;         ///< the vehicle moves enough to tell
    double position_s = 0.0;       ///< of the positions
    double position_rmse_m = 0.0;  ///< of what is left of the positions' error then
    double orientation_s = 0.0;    ///< of the orientations
};

/// Least squares, linear in the shift:
///   positions     T p_est - p_true = s v_true + a x p_true + b
///   orientations  Log(q_true^-1 T q_est) = s w_true + R_true^T a + b
/// with the SE(3) alignment T, and a, b for what is left of it. Velocities are central differences of the true poses.
/// For information only: no error is computed with it. Not known if there are fewer than ten poses with neighbours
/// within a quarter of a second, or the true path is shorter than a metre. Heap. Reentrant.
TimeShift time_shift(std::span<const PosePair> pairs);

}  // namespace facet
