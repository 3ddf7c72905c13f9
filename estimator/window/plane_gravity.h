// SPDX-License-Identifier: BSD-2-Clause
// Level floors and upright walls: found from the estimates, and enforced.
#pragma once

#include "estimator/solver/reduced_system.h"
#include "estimator/window/regularity_config.h"
#include "estimator/window/window_plane.h"

namespace facet {

/// Updates which planes are held level or upright (WindowPlane::is_aligned): those of that kind with enough landmarks,
/// once their angle is within the gate, and as long as it stays within one and a half times the gate. Reentrant. No
/// heap.
void align_planes(const RegularityConfig& config, WindowPlanes& planes);

/// Adds the residuals of aligned planes to the system. @param first_row  of the first plane's variables
/// @return the robust cost. Reentrant. No heap.
double add_plane_gravity(const WindowPlanes& planes, int first_row, ReducedSystem& system);

}  // namespace facet
