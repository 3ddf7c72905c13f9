// SPDX-License-Identifier: BSD-2-Clause
// Finds the triangle of a triangulation that holds a point.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "mesh/delaunay.h"

namespace facet {

/// Walks from a triangle near the point, which a coarse grid gives, towards it. O(1) for evenly spread points.
/// Not exact on edges: a point within rounding of one may be given to either side. Thread-bound. No heap.
class TriangleLocator {
public:
    /// Both spans must outlive the locator's use.
    void build(std::span<const Triangle> triangles, std::span<const Eigen::Vector2d> points);

    /// Index of the triangle, or -1 if the point lies outside the convex hull.
    int locate(const Eigen::Vector2d& xy) const;

private:
    static constexpr int kCells = 16;  ///< a side of the grid: about two triangles a cell for 300 points
    std::size_t cell_of(const Eigen::Vector2d& xy) const;

    std::span<const Triangle> triangles_;
    std::span<const Eigen::Vector2d> points_;
    Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
    Eigen::Vector2d cells_per_unit_ = Eigen::Vector2d::Zero();
    std::array<std::int16_t, static_cast<std::size_t>(kCells) * kCells> start_{};
};

}  // namespace facet
