// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/plane_gravity_factor.h"

#include <cmath>

namespace facet {
namespace {

void weigh(const Eigen::Vector2d& r, double sigma_rad, const CauchyLoss& loss, PlaneGravityLinearization& out) {
    const double s = r.squaredNorm() / (sigma_rad * sigma_rad);
    const double scale = std::sqrt(loss.weight(s)) / sigma_rad;
    out.cost = loss.cost(s);
    out.r = scale * r;
    out.d_r_d_v *= scale;
}

}  // namespace

void linearize_level(const Plane& plane, const Plane& lin, double sigma_rad, const CauchyLoss& loss,
                     PlaneGravityLinearization& out) {
    // R (v x e_x) = -v_1 n, R (v x e_y) = v_0 n.
    const double c = lin.normal_W().z();
    out.d_r_d_v << 0.0, -c, c, 0.0;
    weigh(plane.q_W_P.toRotationMatrix().row(2).head<2>().transpose(), sigma_rad, loss, out);
}

void linearize_upright(const Plane& plane, const Plane& lin, double sigma_rad, const CauchyLoss& loss,
                       PlaneGravityLinearization& out) {
    out.d_r_d_v.setZero();
    out.d_r_d_v.row(0) = lin.d_normal_d_v().row(2);
    weigh({plane.normal_W().z(), 0.0}, sigma_rad, loss, out);
}

}  // namespace facet
