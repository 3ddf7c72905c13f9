// SPDX-License-Identifier: BSD-2-Clause
// How a camera turns from image to image.
#pragma once

#include <optional>
#include <span>

#include "app/lab/check/free_matches.h"
#include "estimator/geometry/camera_model.h"
#include "platform/base/timestamp.h"

namespace facet {

/// How the left camera turned between two frames, by its images.
struct CameraTurn {
    Timestamp from;
    Timestamp to;
    Eigen::Vector3d theta_C = Eigen::Vector3d::Zero();  ///< Log(R_C_from_C_to) (rad)
};

/// Rotation of a camera between two images, whatever its translation: the R and unit t with
///   t . (f0 x R f1) = 0
/// for all bearings f0, f1 of the points, as angles, by Gauss-Newton with Cauchy's weights. It starts from the rotation
/// that explains all of the motion best, with t along each axis: the cost has local minima. The idea is [Kneip13]'s.
/// Empty if fewer than 20 points have a bearing. Reentrant. Heap.
///
/// [Kneip13] Direct Optimization of Frame-to-Frame Rotation, ICCV 2013.
std::optional<Eigen::Vector3d> estimate_turn(const CameraModel& camera, std::span<const PointPair> pairs);

/// The orthogonal matrix R with the largest trace of R^T h; a rotation if asked for. Reentrant.
Eigen::Matrix3d nearest_orthogonal(const Eigen::Matrix3d& h, bool is_rotation);

}  // namespace facet
