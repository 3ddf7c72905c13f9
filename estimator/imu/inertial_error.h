// SPDX-License-Identifier: BSD-2-Clause
// What inertial readings are off by, if states that owe nothing to them are right.
#pragma once

#include "estimator/imu/preintegration.h"
#include "estimator/values/nav_state.h"

namespace facet {

/// An error of the readings that is constant between two states, which explains their poses and the velocity at the
/// first. Readings w + e_w and a + e_a, in B, give over h seconds, to first order,
///   dR = R_i^T R_j Exp(h e_w),    dp = R_i^T (p_j - p_i - h v_i - 1/2 h^2 g) + 1/2 h^2 e_a
/// @param ij  the readings integrated from i to j; the bias of i is subtracted
/// @return e, reading minus truth; zero if the interval is empty. Reentrant. No heap.
ImuBias inertial_error(const NavState& i, const NavState& j, const Preintegration& ij);

/// The same from three poses in a row, whose velocities may be wrong: e_w from the last two, e_a, constant over both
/// intervals, from what the second interval's end is off by if the first one gives the velocity:
///   p_k predicted - p_k = 1/2 h_jk (h_ij R_i + h_jk R_j) e_a
/// With R_i taken for R_j. @return zero if an interval is empty. Reentrant. No heap.
ImuBias inertial_error(const NavState& i, const NavState& j, const NavState& k, const Preintegration& ij,
                       const Preintegration& jk);

}  // namespace facet
