// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/coplanarity_factor.h"

#include <cmath>

namespace facet {

Status linearize_coplanarity(const Plane& plane, const Plane& plane_lin, const CameraPose& host,
                             const InverseDepthPoint& point, double sigma_m, const HuberLoss& loss,
                             CoplanarityLinearization& out) {
    if (!(point.rho > PlaneChart::kMinRho)) {
        return Status::kDegenerate;
    }
    const Eigen::Vector3d p_W = ScaledWorldPoint(host, point).p_W();
    const double r = PlaneChart(plane, host).height(point) / sigma_m;
    const double s = r * r;
    const double scale = std::sqrt(loss.weight(s)) / sigma_m;
    out.weight = loss.weight(s);
    out.cost = loss.cost(s);
    out.r = scale * sigma_m * r;
    out.d_r_d_plane.head<2>() = scale * (p_W - plane_lin.anchor_W).transpose() * plane_lin.d_normal_d_v();
    out.d_r_d_plane(2) = -scale;
    out.d_r_d_point = scale * PlaneChart(plane_lin, host).d_height_d_point(point);
    return Status::kOk;
}

}  // namespace facet
