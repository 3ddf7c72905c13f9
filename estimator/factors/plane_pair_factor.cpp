// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/plane_pair_factor.h"

#include <cmath>

namespace facet {
namespace {

void weigh(const Eigen::Vector2d& r, double sigma_rad, const CauchyLoss& loss, PlanePairLinearization& out) {
    const double s = r.squaredNorm() / (sigma_rad * sigma_rad);
    const double scale = std::sqrt(loss.weight(s)) / sigma_rad;
    out.cost = loss.cost(s);
    out.r = scale * r;
    out.d_r_d_a *= scale;
    out.d_r_d_b *= scale;
}

}  // namespace

void linearize_parallel(const PlaneSide& a, const PlaneSide& b, double sigma_rad, const CauchyLoss& loss,
                        PlanePairLinearization& out) {
    const Eigen::Matrix<double, 3, 2> basis = a.plane->q_W_P.toRotationMatrix().leftCols<2>();
    const Eigen::Matrix3d R_lin = a.plane_lin->q_W_P.toRotationMatrix();
    const Eigen::Vector3d b_lin = b.plane_lin->normal_W();
    // R (v x e_x) = -v_1 n, R (v x e_y) = v_0 n.
    const double c = R_lin.col(2).dot(b_lin);
    out.d_r_d_a << 0.0, -c, c, 0.0;
    out.d_r_d_b = R_lin.leftCols<2>().transpose() * b.plane_lin->d_normal_d_v();
    weigh(basis.transpose() * b.plane->normal_W(), sigma_rad, loss, out);
}

void linearize_orthogonal(const PlaneSide& a, const PlaneSide& b, double sigma_rad, const CauchyLoss& loss,
                          PlanePairLinearization& out) {
    out.d_r_d_a.setZero();
    out.d_r_d_b.setZero();
    out.d_r_d_a.row(0) = b.plane_lin->normal_W().transpose() * a.plane_lin->d_normal_d_v();
    out.d_r_d_b.row(0) = a.plane_lin->normal_W().transpose() * b.plane_lin->d_normal_d_v();
    weigh({a.plane->normal_W().dot(b.plane->normal_W()), 0.0}, sigma_rad, loss, out);
}

}  // namespace facet
