// SPDX-License-Identifier: BSD-2-Clause
// How depth from a stereo pair depends on the cameras' calibration.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/camera_corrections.h"

namespace facet {

using CamerasRow = Eigen::Matrix<double, 1, CameraCorrections::kDim>;

/// Derivative of a point's inverse depth 1 / Z in C0 (1/m) by the cameras' parameters, for fixed pixels in both images.
/// With q = R (x + dx) + q x dtheta + rho (t - R_C1_B dp) and the right image x1 = q.xy / q.z - dx1, the inverse depth
/// rho follows whatever moves x1 along its line. Reentrant. No heap.
/// @param p_C0  in front of both cameras
CamerasRow d_inverse_depth_d_cameras(const Eigen::Vector3d& p_C0, const StereoRig& rig);

/// Standard deviation of the inverse depth of a point straight ahead that the calibration's uncertainty leaves (1/m):
/// nearly the same for all points of a view, as it is an angle over the baseline. 0 if there is no right camera.
double inverse_depth_sigma(double depth_m, const StereoRig& rig, const CameraCorrections& cameras);

}  // namespace facet
