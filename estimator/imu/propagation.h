// SPDX-License-Identifier: BSD-2-Clause
// Covariance of a state predicted from another by inertial samples.
#pragma once

#include <Eigen/Core>

#include "estimator/imu/preintegration.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/nav_state.h"

namespace facet {

using StateCovariance = Eigen::Matrix<double, kStateDim, kStateDim>;

/// P_j = F P_i F^T + Q for x_j = preintegration.predict(x_i), order [theta p v bg ba]: F is the first derivative of
/// predict() at x_i, Q the preintegrated covariance and that of the biases' random walk.
/// Reentrant. No heap.
StateCovariance propagate_covariance(const NavState& state_i, const StateCovariance& covariance_i,
                                     const Preintegration& preintegration, const ImuNoise& noise);

}  // namespace facet
