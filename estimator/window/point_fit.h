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

    /// Adds one camera: r = whitening (q.xy / q.z - xy), q = R_C_W (p - p_W_C). @return false if the point is behind it
    bool add(const CameraPose& camera, const Eigen::Vector3d& p_W, const Eigen::Vector2d& xy,
             const Eigen::Matrix2d& whitening) {
        const Eigen::Vector3d q = camera.R_C_W * (p_W - camera.p_W_C);
        if (!(q.z() > 1e-3)) {
            return false;
        }
        const Eigen::Matrix<double, 2, 3> d_image_d_p =
            (camera.R_C_W.topRows<2>() - q.head<2>() / q.z() * camera.R_C_W.row(2)) / q.z();
        const Eigen::Matrix<double, 2, 3> d = whitening * d_image_d_p;
        information += d.transpose() * d;
        squared_error += (whitening * (q.head<2>() / q.z() - xy)).squaredNorm();
        rows += 2;
        return true;
    }

    /// Adds every sighting of a landmark at p_W. @return false if one is behind its left camera
    bool add_all(const Landmark& landmark, const WindowCameras& cameras, const Eigen::Vector3d& p_W) {
        for (const LandmarkObservation& o : landmark.observations) {
            if (!add(cameras.left(o.keyframe), p_W, o.measurement.left_xy, cameras.whitening_left(o))) {
                return false;
            }
            if (o.measurement.has_right &&
                add(cameras.right(o.keyframe), p_W, o.measurement.right_xy, cameras.whitening_right(o))) {
                ++stereo;
            }
        }
        return true;
    }
};

}  // namespace facet
