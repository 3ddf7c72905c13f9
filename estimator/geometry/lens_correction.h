// SPDX-License-Identifier: BSD-2-Clause
// How the undistorted image of a pixel moves when the camera's intrinsics are corrected.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/camera_model.h"

namespace facet {

/// Corrections of a camera's intrinsics [fx fy cx cy, coefficients]: focal lengths relative (-), principal point (px),
/// the four coefficients of the distortion in the order of CameraIntrinsics (-).
inline constexpr int kLensDim = 8;
inline constexpr int kLensPrincipal = 2;   ///< offset of the principal point
inline constexpr int kLensDistortion = 4;  ///< offset of the coefficients
using LensCorrection = Eigen::Matrix<double, kLensDim, 1>;
/// Of an undistorted point. In single precision: times a correction, a thousandth of a pixel needs three digits.
using LensJacobian = Eigen::Matrix<float, 2, kLensDim>;

/// The intrinsics corrected, which need not be those of a valid camera.
CameraIntrinsics corrected(const CameraIntrinsics& intrinsics, const LensCorrection& correction);

/// The camera with its intrinsics corrected; the camera itself if the result is not a valid one.
CameraModel corrected(const CameraModel& camera, const LensCorrection& correction);

/// Derivative of the normalised undistorted point xy of a fixed pixel by the corrections, at none: with the distortion
/// x' = D(x; k) and its Jacobian J = dD/dx,
///   x'(u) = (u - c) / f,   dx = J^-1 (dx' - dD/dk dk),   dx' = -(x' df / f + dc / f).
/// To first order the corrected point is xy + d_xy_d_lens * correction. What the second order leaves of corrections of
/// a good calibration's three sigmas stays below 0.07 px in the corners of a lens of 80 degrees.
/// Columns of coefficients that the camera does not have are zero.
/// Reentrant. No heap.
LensJacobian d_xy_d_lens(const CameraModel& camera, const Eigen::Vector2d& xy);

}  // namespace facet
