// SPDX-License-Identifier: BSD-2-Clause
// Parallel and orthogonal planes, level floors and upright walls: found from the estimates, and enforced.
#pragma once

#include "estimator/solver/reduced_system.h"
#include "estimator/window/regularity_config.h"
#include "estimator/window/window_plane.h"

namespace facet {

/// Updates the pairs with the planes' estimates: a pair enters when its angle is within the gate of 0 or 90 degrees,
/// and stays within one and a half times the gate; only planes with enough constraints take part. Reentrant. No heap.
void find_plane_pairs(const WindowPlanes& planes, const RegularityConfig& config, PlanePairs& pairs);

/// Adds the pairs' residuals to the system. @param first_row  of the first plane's variables
/// @return the robust cost. Reentrant. No heap.
double add_plane_pairs(const WindowPlanes& planes, const PlanePairs& pairs, int first_row, ReducedSystem& system);

}  // namespace facet
