// SPDX-License-Identifier: BSD-2-Clause
// The space at the vehicle's height, for planners in the plane.
#pragma once

#include "app/view/view_snapshot.h"
#include "mesh/occupancy_grid.h"

namespace facet {

/// Columns of the grid, as a sweep judges them (GridSweepRequest): occupied if a cell from below_m to above_m of the
/// vehicle's height is, free if all cells within wedge_m of it are, else unknown. Reentrant. Heap, unless there is room
/// in the cells.
void slice_at(const Eigen::Vector3d& p_W, const OccupancyGrid& grid, ViewGrid& slice);

}  // namespace facet
