// SPDX-License-Identifier: BSD-2-Clause
// Factors on the relative orientation of two planes, or of a plane and gravity.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/plane.h"
#include "estimator/geometry/robust_loss.h"

namespace facet {

/// Whitened, robustly weighted linearization with respect to the rotations v of both normals. The second row is zero
/// for orthogonal sides.
struct PlanePairLinearization {
    Eigen::Vector2d r;
    Eigen::Matrix2d d_r_d_a;
    Eigen::Matrix2d d_r_d_b;
    double cost = 0.0;  ///< robust
};

/// One side: where the residual is evaluated and where the Jacobians are. The vertical is a side that stays fixed.
struct PlaneSide {
    const Plane* plane = nullptr;
    const Plane* plane_lin = nullptr;
};

/// Parallel or opposite normals: r = [a_x . n_b, a_y . n_b] / sigma, a_x and a_y the basis of a's tangent space.
void linearize_parallel(const PlaneSide& a, const PlaneSide& b, double sigma_rad, const CauchyLoss& loss,
                        PlanePairLinearization& out);

/// Orthogonal normals: r = n_a . n_b / sigma.
void linearize_orthogonal(const PlaneSide& a, const PlaneSide& b, double sigma_rad, const CauchyLoss& loss,
                          PlanePairLinearization& out);

}  // namespace facet
