// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/triangle_locator.h"

#include <algorithm>

namespace facet {

std::size_t TriangleLocator::cell_of(const Eigen::Vector2d& xy) const {
    const Eigen::Vector2d cell = (xy - low_).cwiseProduct(cells_per_unit_).cwiseMax(0.0).cwiseMin(kCells - 1.0);
    return static_cast<std::size_t>(cell.y()) * kCells + static_cast<std::size_t>(cell.x());
}

void TriangleLocator::build(std::span<const Triangle> triangles, std::span<const Eigen::Vector2d> points) {
    triangles_ = triangles;
    points_ = points;
    if (triangles.empty()) {
        return;
    }
    Eigen::Vector2d high = points[0];
    low_ = points[0];
    for (const Eigen::Vector2d& p : points) {
        low_ = low_.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    cells_per_unit_ = kCells * (high - low_).cwiseMax(1e-12).cwiseInverse();
    start_.fill(-1);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const auto& p = triangles[i].point;
        start_[cell_of((points[p[0]] + points[p[1]] + points[p[2]]) / 3.0)] = static_cast<std::int16_t>(i);
    }
    std::int16_t last = 0;
    for (std::int16_t& start : start_) {  // empty cells start where the row's last one does
        last = start < 0 ? last : start;
        start = last;
    }
}

int TriangleLocator::locate(const Eigen::Vector2d& xy) const {
    if (triangles_.empty()) {
        return -1;
    }
    int now = start_[cell_of(xy)];
    // In a Delaunay triangulation such a walk never returns to a triangle, so this bound is never reached in practice.
    for (std::size_t step = 0; step <= triangles_.size(); ++step) {
        const Triangle& t = triangles_[static_cast<std::size_t>(now)];
        bool inside = true;
        for (std::size_t k = 0; k < 3 && inside; ++k) {
            const Eigen::Vector2d& a = points_[t.point[k]];
            const Eigen::Vector2d side = points_[t.point[(k + 1) % 3]] - a;
            const Eigen::Vector2d to = xy - a;
            if (side.x() * to.y() - side.y() * to.x() < 0.0) {
                inside = false;
                now = t.neighbour[k];
            }
        }
        if (inside || now < 0) {
            return now;
        }
    }
    return -1;
}

}  // namespace facet
