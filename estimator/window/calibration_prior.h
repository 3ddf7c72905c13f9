// SPDX-License-Identifier: BSD-2-Clause
// What is known of the calibration before anything has been seen.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/stereo_rig.h"
#include "estimator/window/calibration_config.h"
#include "estimator/window/rig_calibration.h"

namespace facet {

/// A symmetric matrix over the calibration's first parameters, as many as are estimated. On the stack, no heap.
using CalibrationMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kCalibrationDim, kCalibrationDim>;

/// Covariance of the calibration as given, config.dim() square, in the order of RigCalibration. Diagonal but for the
/// cameras' poses: each has an error of its own, e0 and e1, so that the right camera's pose against the left one has
/// the error e1 - e0, correlated with that of the pair, which is the left one's:
///   cov(theta, right theta) = -sigma^2 R_Bc_C1,   cov(p, right p) = -sigma^2 I.
/// (The lever arm of the cameras times their errors of rotation, a tenth of those of position, is left out.) Reentrant.
CalibrationMatrix calibration_covariance(const CalibrationConfig& config, const StereoRig& given);

/// Inverse of a covariance. @return false if it is not positive definite (output untouched). Reentrant.
bool invert_covariance(const CalibrationMatrix& covariance, CalibrationMatrix& information);

}  // namespace facet
