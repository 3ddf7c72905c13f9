// SPDX-License-Identifier: BSD-2-Clause
// How two planes, or a plane and gravity, lie to each other.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/plane.h"
#include "estimator/geometry/robust_loss.h"

namespace facet {

/// Whitened, robustly weighted linearization with respect to the normals' turns v of both sides. The second row is zero
/// for orthogonal sides.
struct PlanePairLinearization {
    Eigen::Vector2d r;
    Eigen::Matrix2d d_r_d_a;
    Eigen::Matrix2d d_r_d_b;
    double cost = 0.0;  ///< robust
};

/// One side: where the residual is taken and where the Jacobians are. The vertical is a side that nobody moves.
struct PlaneSide {
    const Plane* plane = nullptr;
    const Plane* plane_lin = nullptr;
};

/// Parallel or opposite normals: r = [a_x . n_b, a_y . n_b] / sigma, a_x and a_y the basis of a's tangent space.
void linearize_parallel(const PlaneSide& a, const PlaneSide& b, double sigma_rad, const HuberLoss& loss,
                        PlanePairLinearization& out);

/// Orthogonal normals: r = n_a . n_b / sigma.
void linearize_orthogonal(const PlaneSide& a, const PlaneSide& b, double sigma_rad, const HuberLoss& loss,
                          PlanePairLinearization& out);

}  // namespace facet
