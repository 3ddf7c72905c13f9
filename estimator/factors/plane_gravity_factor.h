// SPDX-License-Identifier: BSD-2-Clause
// Factors on the angle between a plane and gravity: floors are level, walls upright.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/plane.h"
#include "estimator/geometry/robust_loss.h"

namespace facet {

/// Whitened, robustly weighted linearization with respect to the rotation v of the normal. The second row is zero for
/// an upright plane.
struct PlaneGravityLinearization {
    Eigen::Vector2d r;
    Eigen::Matrix2d d_r_d_v;
    double cost = 0.0;  ///< robust
};

/// A level plane: r = [x . e_z, y . e_z] / sigma, where x and y span the plane and e_z points up.
/// @param lin  where the Jacobian is evaluated. Reentrant. No heap.
void linearize_level(const Plane& plane, const Plane& lin, double sigma_rad, const CauchyLoss& loss,
                     PlaneGravityLinearization& out);

/// An upright plane: r = n . e_z / sigma, n being its normal. Otherwise as linearize_level().
void linearize_upright(const Plane& plane, const Plane& lin, double sigma_rad, const CauchyLoss& loss,
                       PlaneGravityLinearization& out);

}  // namespace facet
