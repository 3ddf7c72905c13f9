// SPDX-License-Identifier: BSD-2-Clause
// Points of semi-dense depth as evidence of the grid.
#include <algorithm>

#include "mesh/occupancy_grid.h"

namespace facet {

/// Half a face's evidence: two keyframes make an obstacle.
void OccupancyGrid::hint(const Eigen::Vector3d& p_W) {
    const Eigen::Vector3i c = cell_of(p_W);
    if (!holds(c)) {
        return;
    }
    const std::size_t index = index_of(c);
    Cell& cell = cells_[index];
    if (cell.tick != tick_ || cell.evidence < 0) {
        const int before = std::max<int>(cell.evidence, 0);
        if (before < kOccupied) {
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
    // Points leave gaps: a cell that no face has marked stays occupied as a whole.
    for (const DepthPoint& point : points) {
        const Eigen::Vector3i c = cell_of(point.p_W);
        if (is_sharp(point) && holds(c) && surface_[index_of(c)] != 0) {
            surface_[index_of(c)] |= part_bit(part_of(point.p_W));
        }
    }
}

}  // namespace facet
