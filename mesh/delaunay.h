// SPDX-License-Identifier: BSD-2-Clause
// Delaunay triangulation of points in the plane, with exact predicates; points can be added to it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "mesh/capacity.h"
#include "mesh/edge_rings.h"
#include "platform/base/fixed_vector.h"
#include "platform/base/status.h"

namespace facet {

/// One triangle: indices of its points, counterclockwise in the (x right, y up) sense of the coordinates, the smallest
/// index first; and of its neighbours, neighbour i across the edge from point i to point i+1, or -1 at the hull.
struct Triangle {
    std::array<std::uint16_t, 3> point{};
    std::array<std::int16_t, 3> neighbour{-1, -1, -1};
};

/// Divide and conquer [Guibas85] with exact predicates [Shewchuk97]. No triangle's circumcircle holds a point, the
/// triangles cover the convex hull, and no input makes it fail: equal points count once (the first one is used), points
/// on one line give no triangle, and where more than three points lie on a circle the choice depends on the coordinates
/// only, not on the order of the points. Cuts alternate between x and y [Dwyer87]: joining narrow slabs would create
/// long edges that the next join deletes. O(n log n). Thread-bound (it has a workspace). No heap.
class Delaunay : private EdgeRings {
public:
    /// @param points  at most kMaxMeshPoints, |coordinate| <= 1e9; one below 1e-60 counts as zero
    /// @return kFull if there are more points, kInvalidArgument if a coordinate is not finite or too large; then there
    ///         are no triangles
    Status triangulate(std::span<const Eigen::Vector2d> points);

    /// Adds points to the last triangulation, one after the other [Guibas85, sec. 10]. Points outside its hull, or on
    /// its border, are left out. Where more than three points lie on a circle the choice depends on their order.
    /// @param points  those of the last call, followed by the new ones
    /// @return as above; kInvalidArgument also if there are fewer points than before
    Status insert(std::span<const Eigen::Vector2d> points);

    std::span<const Triangle> triangles() const { return {triangles_.data(), triangles_.size()}; }

    /// Points that were equal to an earlier one in the last triangulation.
    int duplicates() const { return duplicates_; }

private:
    static constexpr std::int16_t kOutside = -1;  ///< as left face of an edge
    static constexpr std::int16_t kNotVisited = -2;
    struct Key {
        double x;
        double y;
        std::uint16_t index;
    };
    /// Order of the points: kX by x, then y; kY by y, then -x, which is the same after a turn by a right angle.
    enum class Axis : std::uint8_t { kX, kY };
    struct Hull {
        Edge left;   ///< counterclockwise out of the first point along the axis
        Edge right;  ///< clockwise out of the last one
    };

    /// kFull and kInvalidArgument as triangulate().
    static Status check(std::span<const Eigen::Vector2d> points);
    /// With coordinates that the exact predicates can multiply.
    static Eigen::Vector2d without_underflow(const Eigen::Vector2d& p);
    static Axis other(Axis axis) { return axis == Axis::kX ? Axis::kY : Axis::kX; }
    template <class Point>
    static bool is_before(Axis axis, const Point& a, const Point& b);

    const Eigen::Vector2d& at(std::uint16_t rank) const { return sorted_[rank]; }
    bool left_of(std::uint16_t p, Edge e) const;
    bool right_of(std::uint16_t p, Edge e) const;

    void sort(std::span<const Eigen::Vector2d> points);
    void arrange(int first, int count, Axis axis);
    Hull build(int first, int count, Axis axis);
    Hull build_three(std::uint16_t first);
    Hull merge(Hull left, Hull right);
    /// An edge that may be the next across the seam, and whether it rises above the base.
    struct Candidate {
        Edge edge;
        bool is_valid;
    };
    template <class Following>
    Candidate candidate(Edge base, Edge first, Following following);
    Hull ends_along(Axis axis, Edge on_hull) const;
    Edge locate(const Eigen::Vector2d& p, Edge from) const;
    bool add_point(const Eigen::Vector2d& p, std::uint16_t index, Edge& near);
    void collect();

    int duplicates_ = 0;
    int points_ = 0;  ///< number of points given
    int count_ = 0;   ///< number of these in the triangulation
    Edge hull_ = 0;   ///< some edge of the hull, counterclockwise
    std::array<std::int16_t, kMaxEdges> left_face_{};
    std::array<Edge, kMaxTriangles> first_edge_{};        ///< of each triangle
    std::array<Key, kMaxMeshPoints> keys_{};              ///< scratch of sort()
    std::array<Eigen::Vector2d, kMaxMeshPoints> sorted_;  ///< distinct points; the halves of each cut are adjacent
    std::array<std::uint16_t, kMaxMeshPoints> index_{};   ///< of each of them in the input
    FixedVector<Triangle, kMaxTriangles> triangles_;
};

}  // namespace facet
