// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/coplanarity_factor.h"

#include <cmath>

namespace facet {

Status linearize_coplanarity(const Plane& plane, const Plane& plane_lin, const CameraPose& host,
                             const InverseDepthPoint& point, double sigma_m, const HuberLoss& loss,
                             CoplanarityLinearization& out) {
    constexpr double kMinRho = 0.01;  // 1/m
    if (!(point.rho > kMinRho)) {
        return Status::kDegenerate;
    }
    const ScaledWorldPoint world(host, point);
    const Eigen::Vector3d p_W = world.p_W();
    const double r = plane.height(p_W) / sigma_m;
    const double s = r * r;
    const double scale = std::sqrt(loss.weight(s)) / sigma_m;
    const Eigen::Vector3d n_lin = plane_lin.normal_W();
    out.weight = loss.weight(s);
    out.cost = loss.cost(s);
    out.r = scale * sigma_m * r;
    out.d_r_d_plane.head<2>() = scale * (p_W - plane_lin.anchor_W).transpose() * plane_lin.d_normal_d_v();
    out.d_r_d_plane(2) = -scale;
    const Eigen::RowVector3d n_H = (scale / point.rho) * (host.R_C_W * n_lin).transpose();
    out.d_r_d_point.head<2>() = n_H.head<2>();
    out.d_r_d_point(2) = -(scale / (point.rho * point.rho)) * n_lin.dot(world.ray_W);
    return Status::kOk;
}

}  // namespace facet
