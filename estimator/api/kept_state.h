// SPDX-License-Identifier: BSD-2-Clause
// What of an estimate outlives the program that made it.
#pragma once

#include <Eigen/Core>

#include "estimator/api/estimate.h"
#include "estimator/values/nav_state.h"

namespace facet {

/// Attitude, position, velocity and biases with their standard deviations, order [theta p v bg ba] as in NavState, and
/// the calibration; see Estimator::keep() and resume().
struct KeptState {
    NavState state;
    Eigen::Matrix<double, kStateDim, 1> sigma = Eigen::Matrix<double, kStateDim, 1>::Zero();
    CalibrationEstimate calibration;
};

}  // namespace facet
