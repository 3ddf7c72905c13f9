// SPDX-License-Identifier: BSD-2-Clause
// How well one stereo observation knows where a point is.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/stereo_rig.h"

namespace facet {

/// Covariance of a point in C0 from its pixels in both images, each coordinate of standard deviation sigma_px:
///   (J^T J / sigma_px^2 + I / |p|^2)^-1,  J = d(uv_0, uv_1) / dp, 4x3
/// The lenses' derivatives are in J, so that it holds at any angle off the axis, and along the baseline, where the
/// distance is hardly seen. The last term says that a point is at most as uncertain as it is far: all that is known if
/// the model of a camera does not reach the point. Reentrant. No heap.
/// @param T_C1_C0  of the rig
/// @param p_C0     the point, not at the origin (m)
/// @return 3x3 (m^2)
Eigen::Matrix3d stereo_covariance(const StereoRig& rig, const Se3& T_C1_C0, const Eigen::Vector3d& p_C0,
                                  double sigma_px);

}  // namespace facet
