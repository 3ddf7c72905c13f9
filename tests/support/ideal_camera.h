// SPDX-License-Identifier: BSD-2-Clause
// A camera without distortion, and where it looks: what made-up scenes of tests are seen with.
#pragma once

#include "estimator/geometry/camera_model.h"
#include "estimator/geometry/se3.h"

namespace facet::test {

/// Square pixels of focal length f (px), no distortion, the optical axis through the image's middle.
inline CameraModel ideal_camera(int width, int height, double f) {
    CameraIntrinsics k;
    k.width = width;
    k.height = height;
    k.fx = k.fy = f;
    k.cx = 0.5 * (width - 1);
    k.cy = 0.5 * (height - 1);
    return CameraModel(k);
}

/// Pose in W of a camera at p (m) that looks along W's x axis, upright: its axes are (-y, -z, x) of W.
inline Se3 looking_along_x(const Eigen::Vector3d& p = Eigen::Vector3d::Zero()) {
    Eigen::Matrix3d R;
    R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
    return {Eigen::Quaterniond(R), p};
}

}  // namespace facet::test
