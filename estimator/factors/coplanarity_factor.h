// SPDX-License-Identifier: BSD-2-Clause
// A landmark lies on a plane.
#pragma once

#include "estimator/geometry/plane_chart.h"
#include "estimator/geometry/robust_loss.h"
#include "platform/base/status.h"

namespace facet {

/// Whitened, robustly weighted linearization of one co-planarity residual.
struct CoplanarityLinearization {
    double r = 0.0;
    Eigen::RowVector3d d_r_d_plane;  ///< order [v h]
    Eigen::RowVector3d d_r_d_point;  ///< order [x y rho] of the host chart
    double cost = 0.0;               ///< robust
    double weight = 1.0;             ///< of the robust loss, in (0, 1]
};

/// Co-planarity residual of [Rosinol19], n . p - d, about the plane's anchor:
///   r = (n . (p - o) - h) / sigma,    p = c + R_W_H (x, y, 1) / rho.
/// @param plane      where the residual is evaluated
/// @param plane_lin  where the Jacobians are evaluated (first-estimate Jacobians); equal to `plane` if free
/// @return kDegenerate if the point is practically at infinity (outputs untouched). No heap. Reentrant.
Status linearize_coplanarity(const Plane& plane, const Plane& plane_lin, const CameraPose& host,
                             const InverseDepthPoint& point, double sigma_m, const HuberLoss& loss,
                             CoplanarityLinearization& out);

}  // namespace facet
