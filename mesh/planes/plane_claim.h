// SPDX-License-Identifier: BSD-2-Clause
// How well a plane is known in the world of the estimate.
#pragma once

#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/keyframe_view.h"
#include "mesh/planes/plane_fit.h"
#include "mesh/planes/plane_memory.h"

namespace facet {

/// A plane n . p = d, by its height at the centroid (m) and the turns that lift points along and across (rad).
using PlaneCovariance = Eigen::Matrix3d;

/// What the uncertainty of the stereo calibration does to a plane whose points are measured in one stereo pair: each
/// point of the plane is where the pair sees it, and moves as its disparity does.
/// @param rig      as given, its left camera the view's  @param cameras  corrections of it, with their covariance
/// @return zero if less than four points spread over the landmarks' extent are in front of the cameras. No heap.
/// Reentrant.
PlaneCovariance effect_of_calibration(const PlaneFit& fit, const StereoRig& rig, const CameraCorrections& cameras,
                                      const Se3& T_W_C0);

/// The plane with its uncertainty in the world, in place of what its landmarks say as if each erred for
/// itself and poses and calibration were true:
///   * n heights that share c of their errors count as n / (1 + c (n - 1)) independent ones, as to the estimator
///     (RegularityConfig::kHeightCorrelation);
///   * the vehicle's heading and place, from where the plane was last found, move and turn it;
///   * so does the calibration of the stereo pair, as far as it is not known (effect_of_calibration()).
/// No heap. Reentrant.
PlaneFit claimed_in_world(const PlaneFit& fit, const SightedFrom& from, const PlaneCovariance& calibration);

}  // namespace facet
