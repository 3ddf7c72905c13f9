// SPDX-License-Identifier: BSD-2-Clause
// Points of semi-dense depth as evidence of the grid.
#include <algorithm>

#include "mesh/occupancy_grid.h"

namespace facet {

/// Half a face's evidence: two keyframes make an obstacle. Its parts are those of both.
void OccupancyGrid::hint(const Eigen::Vector3d& p_W) {
    const Eigen::Vector3i c = cell_of(p_W);
    if (!holds(c)) {
        return;
    }
    const std::size_t index = index_of(c);
    Cell& cell = cells_[index];
    if (cell.tick != tick_ || cell.evidence < 0) {
        const int before = std::max<int>(cell.evidence, 0);
        if (before == 0) {
            surface_[index] = 0;
        }
        cell.evidence = static_cast<std::int8_t>(std::min(before + 1, kMostOccupied));
        cell.tick = tick_;
    }
}

void OccupancyGrid::add_depth(std::span<const DepthPoint> points) {
    const auto is_sharp = [this](const DepthPoint& p) { return p.sigma_m <= 0.5 * config_.cell_m; };
    for (const DepthPoint& point : points) {
        if (is_sharp(point)) {
            hint(point.p_W);
        }
    }
    for (const DepthPoint& point : points) {
        carve(point.p_W, point.sigma_m, kPointWeight);
    }
    // A cell that became occupied as a whole, by a landmark, stays so. Rays that pass between the points of a surface
    // end behind it, where nothing has been seen: unknown.
    for (const DepthPoint& point : points) {
        const Eigen::Vector3i c = cell_of(point.p_W);
        if (!is_sharp(point) || !holds(c)) {
            continue;
        }
        const std::size_t index = index_of(c);
        const bool is_new = cells_[index].evidence == 1;
        if (is_new || (cells_[index].evidence > 1 && surface_[index] != 0)) {
            surface_[index] |= part_bit(part_of(point.p_W));
        }
    }
}

}  // namespace facet
