// SPDX-License-Identifier: BSD-2-Clause
// The factor between two consecutive keyframes between which the vehicle stood still.
#pragma once

#include <Eigen/Core>

#include "estimator/imu/preintegration.h"
#include "estimator/values/nav_state.h"

namespace facet {

/// Standard deviations of standing still: motion that images and inertial samples cannot distinguish from rest.
struct RestSigmas {
    double theta_rad = 5e-4;  ///< turn between the keyframes: half a pixel of disparity goes unseen
    double p_m = 2e-3;        ///< movement between them: half a pixel at 2 m
    double v_m_per_s = 1e-2;  ///< velocity at the later one
};

/// Whitened residual and Jacobians.
struct RestFactorLinearization {
    Eigen::Matrix<double, 9, 1> r;
    Eigen::Matrix<double, 9, kStateDim> d_r_d_i;
    Eigen::Matrix<double, 9, kStateDim> d_r_d_j;
};

/// No motion and no velocity:
///   r_theta = Log(R_i^T R_j) / sigma_theta,   r_p = R_i^T (p_j - p_i) / sigma_p,   r_v = v_j / sigma_v.
/// It constrains relative motion only: over many keyframes the position may wander, so that a long rest does not make
/// the window more certain of the position than it was when the vehicle stopped. Jacobians at (i_lin, j_lin), residual
/// at (i, j). Reentrant. No heap.
void linearize_rest(const NavState& i, const NavState& j, const NavState& i_lin, const NavState& j_lin,
                    const RestSigmas& sigmas, RestFactorLinearization& out);

}  // namespace facet
