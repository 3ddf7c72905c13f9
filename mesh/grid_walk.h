// SPDX-License-Identifier: BSD-2-Clause
// The cells of an occupancy grid along a ray: private to its sources.
#pragma once

#include <limits>

#include "mesh/occupancy_grid.h"

namespace facet {

/// From boundary to boundary [Amanatides87]: at each step into the neighbour whose boundary is nearest along the ray.
template <class Visit>
void OccupancyGrid::walk(double size, const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double max_m,
                         Visit visit) {
    Eigen::Vector3i cell = (from / size).array().floor().cast<int>();
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
    // Scalars and selections: the axis is as good as random, so that a branch or an index on it would stall every step.
    double x_next = next.x();
    double y_next = next.y();
    double z_next = next.z();
    double entered = 0.0;
    constexpr int kMost = kGridX + kGridY + kGridZ;
    for (int i = 0; i < kMost && entered <= max_m; ++i) {
        if (!visit(cell, entered)) {
            return;
        }
        const bool before_y = x_next < y_next;
        const bool before_z = x_next < z_next;
        const bool along_x = before_y & before_z;
        const bool along_y = !before_y & (y_next < z_next);
        const bool along_z = !along_x & !along_y;
        entered = along_x ? x_next : along_y ? y_next : z_next;
        x_next = along_x ? x_next + width.x() : x_next;
        y_next = along_y ? y_next + width.y() : y_next;
        z_next = along_z ? z_next + width.z() : z_next;
        cell += Eigen::Vector3i(along_x ? step.x() : 0, along_y ? step.y() : 0, along_z ? step.z() : 0);
    }
}

}  // namespace facet
