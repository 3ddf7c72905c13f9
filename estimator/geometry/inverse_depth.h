// SPDX-License-Identifier: BSD-2-Clause
// Points by inverse depth in a host camera, and camera poses in the form that projections need.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/se3.h"

namespace facet {

/// A world point by its normalised image point and inverse depth in a host camera H: p_H = (x, y, 1) / rho.
/// Well conditioned from the near limit to infinity (rho = 0). [Civera08], without the six-parameter host.
struct InverseDepthPoint {
    Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< (X/Z, Y/Z) in the host (-)
    double rho = 0.0;                              ///< 1 / Z in the host (1/m)
};

/// Pose of a camera, split for projection: p_C = R_C_W * (p_W - p_W_C).
struct CameraPose {
    Eigen::Matrix3d R_C_W = Eigen::Matrix3d::Identity();
    Eigen::Vector3d p_W_C = Eigen::Vector3d::Zero();

    static CameraPose from(const Se3& T_W_C) { return {T_W_C.R().transpose(), T_W_C.p}; }
};

/// A world point scaled by rho, so that infinity is finite: (ray_W + rho * (centre_W - c)) is parallel to the line from
/// any camera centre c to the point.
struct ScaledWorldPoint {
    Eigen::Vector3d ray_W;     ///< R_W_H * (x, y, 1)
    Eigen::Vector3d centre_W;  ///< p_W_H (m)
    double rho = 0.0;          ///< (1/m)

    ScaledWorldPoint(const CameraPose& host, const InverseDepthPoint& point)
        : ray_W(host.R_C_W.transpose() * Eigen::Vector3d(point.xy.x(), point.xy.y(), 1.0)),
          centre_W(host.p_W_C),
          rho(point.rho) {}

    /// rho times the vector from camera centre c to the point, in W.
    Eigen::Vector3d from(const Eigen::Vector3d& p_W_C) const { return ray_W + rho * (centre_W - p_W_C); }
    /// The point (m); rho must not be 0.
    Eigen::Vector3d p_W() const { return centre_W + ray_W / rho; }
    /// The same point in the chart of another camera; the point must lie in front of it.
    InverseDepthPoint in(const CameraPose& camera) const {
        const Eigen::Vector3d q = camera.R_C_W * from(camera.p_W_C);
        return {q.head<2>() / q.z(), rho / q.z()};
    }
};

}  // namespace facet
