// SPDX-License-Identifier: BSD-2-Clause
// How one camera sees the points of another camera's chart.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/inverse_depth.h"

namespace facet {

/// The homogeneous transform of a host camera's coordinates into a camera's. A point of the host's chart is homogeneous
/// itself, finite at infinity, so that
///   q_C = rho p_C = T_C_H (x, y, 1, rho)    (first three rows),
/// and columns 0, 1 and 3 are the derivatives of q_C by x, y and rho. [Civera08]
struct RelativeView {
    Eigen::Matrix4d T_C_H = Eigen::Matrix4d::Identity();

    static RelativeView of(const CameraPose& camera, const CameraPose& host) {
        RelativeView view;
        view.T_C_H.topLeftCorner<3, 3>() = camera.R_C_W * host.R_C_W.transpose();
        view.T_C_H.topRightCorner<3, 1>() = camera.R_C_W * (host.p_W_C - camera.p_W_C);
        return view;
    }

    /// Direction to the point in the camera, rho times its place.
    Eigen::Vector3d sight_line(const InverseDepthPoint& point) const {
        const Eigen::Vector4d q = T_C_H * Eigen::Vector4d(point.xy.x(), point.xy.y(), 1.0, point.rho);
        return q.head<3>();
    }

    /// Derivative of the image point (q.x / q.z, q.y / q.z) = image_xy by (x, y, rho), times q.z.
    Eigen::Matrix<double, 2, 3> d_image_d_point_times_z(const Eigen::Vector2d& image_xy) const {
        Eigen::Matrix<double, 2, 3> d;
        for (int column = 0; column < 3; ++column) {
            const auto t = T_C_H.col(column == 2 ? 3 : column);
            d.col(column) = t.head<2>() - t(2) * image_xy;
        }
        return d;
    }
};

/// True if a sight line points forward: less than 87 degrees off the optical axis.
inline bool is_in_front(const Eigen::Vector3d& q_C) {
    constexpr double kMinCosine = 0.05;
    return q_C.z() > 0.0 && q_C.z() * q_C.z() > kMinCosine * kMinCosine * q_C.squaredNorm();
}

}  // namespace facet
