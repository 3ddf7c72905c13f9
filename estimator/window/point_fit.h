// SPDX-License-Identifier: BSD-2-Clause
// How well a landmark is determined by its sightings, given the poses.
#pragma once

#include <Eigen/Core>

#include "estimator/window/window_cameras.h"

namespace facet {

/// Information about a point and its squared residual, whitened, from the cameras that see it.
struct PointFit {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of p_W (1/m^2)
    double squared_error = 0.0;
    int rows = -3;   ///< scalar residuals minus the point's three parameters
    int stereo = 0;  ///< sightings with a right match

    /// Adds one camera: r = scale (q.xy / q.z - xy), q = R_C_W (p - p_W_C). @return false if the point is behind it
    bool add(const CameraPose& camera, const Eigen::Vector3d& p_W, const Eigen::Vector2d& xy, double scale) {
        const Eigen::Vector3d q = camera.R_C_W * (p_W - camera.p_W_C);
        if (!(q.z() > 1e-3)) {
            return false;
        }
        const double w = scale / q.z();
        const Eigen::RowVector3d u = w * (camera.R_C_W.row(0) - (q.x() / q.z()) * camera.R_C_W.row(2));
        const Eigen::RowVector3d v = w * (camera.R_C_W.row(1) - (q.y() / q.z()) * camera.R_C_W.row(2));
        information += u.transpose() * u + v.transpose() * v;
        squared_error += scale * scale * (q.head<2>() / q.z() - xy).squaredNorm();
        rows += 2;
        return true;
    }

    /// Adds every sighting of a landmark at p_W. @return false if one is behind its left camera
    bool add_all(const Landmark& landmark, const WindowCameras& cameras, const Eigen::Vector3d& p_W) {
        const StereoGeometry& geometry = cameras.geometry();
        for (const LandmarkObservation& o : landmark.observations) {
            if (!add(cameras.left(o.keyframe), p_W, o.measurement.left_xy, geometry.scale_left)) {
                return false;
            }
            if (o.measurement.has_right &&
                add(cameras.right(o.keyframe), p_W, o.measurement.right_xy, geometry.scale_right)) {
                ++stereo;
            }
        }
        return true;
    }
};

}  // namespace facet
