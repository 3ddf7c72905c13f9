// SPDX-License-Identifier: BSD-2-Clause
// Keeps the prior a valid one whatever marginalization has met.
#pragma once

#include "estimator/factors/prior_factor.h"
#include "estimator/solver/reduced_system.h"
#include "platform/base/status.h"

namespace facet {

/// Whether every number is finite and no parameter has negative information: necessary for a valid prior, and cheap.
bool is_plausible(const PriorFactor& prior);

/// Makes an indefinite prior positive semidefinite, as rounding and marginalization of badly conditioned systems may
/// leave it: adds the smallest share of the diagonal, by powers of 100 from 1e-12 on, with which its Cholesky
/// decomposition exists. Up to 8 decompositions of 500 x 500: for emergencies.
/// @param scratch  overwritten
/// @return kDegenerate if it is not finite or no share up to 1 suffices (prior untouched). No heap. Reentrant.
Status make_semidefinite(PriorFactor& prior, ReducedSystem& scratch);

/// Standard deviations of a window that restarts on its own oldest keyframe because its prior was lost, order of the
/// state's tangent: tilt and yaw 0.05 rad, place 0.1 m, velocity 0.3 m/s, biases as before a flight.
Eigen::Matrix<double, kStateDim, 1> emergency_sigmas();

}  // namespace facet
