// SPDX-License-Identifier: BSD-2-Clause
// Mesh, planes and grid as the values that planners are sent.
#pragma once

#include <span>

#include "drivers/world_stream/world_state.h"
#include "mesh/horizon_mesh.h"
#include "mesh/occupancy_grid.h"
#include "mesh/planes/plane_finder.h"

namespace facet {

/// Fills in all of `world` but sequence, stamp and resets: shown positions of the vertices that are there, zero for
/// the others; at most kWorldPlanes planes, the first ones. Reentrant. No heap if `world.planes` has that capacity.
/// @param grid  null: there is none
void describe_world(const HorizonMesh& mesh, std::span<const TrackedPlane> planes, const OccupancyGrid* grid,
                    WorldState& world);

}  // namespace facet
