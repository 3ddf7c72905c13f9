// SPDX-License-Identifier: BSD-2-Clause
// The cells of an occupancy grid along a ray: private to its sources.
#pragma once

#include <limits>

#include "mesh/occupancy_grid.h"

namespace facet {

/// From boundary to boundary [Amanatides87]: at each step into the neighbour whose boundary is nearest along the ray.
template <class Visit>
void OccupancyGrid::walk(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double max_m,
                         Visit visit) const {
    const double size = config_.cell_m;
    Eigen::Vector3i cell = cell_of(from);
    Eigen::Vector3i step;
    Eigen::Vector3d next;   // distance at which the ray leaves the cell along each axis
    Eigen::Vector3d width;  // distance between boundaries
    for (int k = 0; k < 3; ++k) {
        const double d = direction[k];
        step[k] = d > 0.0 ? 1 : -1;
        if (d == 0.0) {
            next[k] = width[k] = std::numeric_limits<double>::infinity();
        } else {
            width[k] = size / std::abs(d);
            next[k] = ((cell[k] + (d > 0.0 ? 1 : 0)) * size - from[k]) / d;
        }
    }
    double entered = 0.0;
    constexpr int kMost = kGridX + kGridY + kGridZ;
    for (int i = 0; i < kMost && entered <= max_m; ++i) {
        if (!visit(cell, entered)) {
            return;
        }
        const int axis = next.x() < next.y() ? (next.x() < next.z() ? 0 : 2) : (next.y() < next.z() ? 1 : 2);
        cell[axis] += step[axis];
        entered = next[axis];
        next[axis] += width[axis];
    }
}

}  // namespace facet
