// SPDX-License-Identifier: BSD-2-Clause
// A plane expressed in the chart of a host camera's points.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/inverse_depth.h"
#include "estimator/geometry/plane.h"

namespace facet {

/// Height above a plane of points given by inverse depth in a host camera H:
///   height(x, y, rho) = n_H . (x, y, 1) / rho + height of H's centre.
class PlaneChart {
public:
    /// Points farther than this are practically at infinity: they have no height (1/m).
    static constexpr double kMinRho = 0.01;

    PlaneChart(const Plane& plane, const CameraPose& host)
        : n_H_(host.R_C_W * plane.normal_W()), centre_m_(plane.height(host.p_W_C)) {}

    /// (m); rho must not be 0.
    double height(const InverseDepthPoint& point) const { return along_ray(point) / point.rho + centre_m_; }
    /// Order [x y rho].
    Eigen::RowVector3d d_height_d_point(const InverseDepthPoint& point) const {
        const double inv_rho = 1.0 / point.rho;
        return {inv_rho * n_H_.x(), inv_rho * n_H_.y(), -inv_rho * inv_rho * along_ray(point)};
    }

private:
    double along_ray(const InverseDepthPoint& point) const {
        return n_H_.x() * point.xy.x() + n_H_.y() * point.xy.y() + n_H_.z();
    }

    Eigen::Vector3d n_H_;
    double centre_m_;
};

}  // namespace facet
