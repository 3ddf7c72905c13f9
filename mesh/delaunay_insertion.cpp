// SPDX-License-Identifier: BSD-2-Clause
// Points added to a triangulation one by one.
#include "mesh/delaunay.h"
#include "mesh/predicates.h"

namespace facet {

/// Walks from an edge to the triangle that holds the point and returns a side that has the triangle on its left; a side
/// of the outside if the point is not in the hull. In a Delaunay triangulation the walk visits no triangle twice.
Delaunay::Edge Delaunay::locate(const Eigen::Vector2d& p, Edge from) const {
    const auto is_right_of = [&](Edge e) { return orientation(p, at(destination(e)), at(origin(e))) > 0.0; };
    Edge e = is_right_of(from) ? reverse(from) : from;
    while (left_face_[e] != kOutside) {
        const Edge second = left_next(e);
        const Edge third = left_next(second);
        if (is_right_of(second)) {
            e = reverse(second);
        } else if (is_right_of(third)) {
            e = reverse(third);
        } else {
            return e;
        }
    }
    return e;
}

/// Connects a point to the corners of its triangle, or of the two beside the side that it lies on, and then turns sides
/// whose circles hold it. @param near  in: where to look first; out: an edge at the point
/// @return false if the point is outside, on the border, or a duplicate
bool Delaunay::add_point(const Eigen::Vector2d& p, std::uint16_t index, Edge& near) {
    Edge e = locate(p, near);
    if (left_face_[e] == kOutside) {
        return false;
    }
    for (int k = 0; k < 3; ++k, e = left_next(e)) {
        if (at(origin(e)) == p) {
            ++duplicates_;
            return false;
        }
    }
    for (int k = 0; k < 3; ++k, e = left_next(e)) {
        if (orientation(p, at(origin(e)), at(destination(e))) == 0.0) {
            if (left_face_[reverse(e)] == kOutside) {
                return false;
            }
            e = previous(e);
            remove(next(e));
            break;
        }
    }
    const auto rank = static_cast<std::uint16_t>(count_++);
    sorted_[rank] = p;
    index_[rank] = index;
    Edge spoke = make_edge(origin(e), rank);
    splice(spoke, e);
    near = spoke;
    do {
        spoke = connect(e, reverse(spoke));
        e = previous(spoke);
    } while (left_next(e) != near);
    for (;;) {
        const std::uint16_t beyond = destination(previous(e));
        if (left_face_[reverse(e)] != kOutside && right_of(beyond, e) &&
            in_circle(at(origin(e)), at(beyond), at(destination(e)), p) > 0.0) {
            turn(e);
            e = previous(e);
        } else if (next(e) == near) {
            return true;
        } else {
            e = left_previous(next(e));
        }
    }
}

Status Delaunay::insert(std::span<const Eigen::Vector2d> points) {
    FACET_TRY(check(points));
    if (points.size() < static_cast<std::size_t>(points_)) {
        return Status::kInvalidArgument;
    }
    const auto first = static_cast<std::size_t>(points_);
    points_ = static_cast<int>(points.size());
    if (triangles_.empty() || first == points.size()) {
        return Status::kOk;
    }
    Edge near = hull_;
    for (std::size_t i = first; i < points.size(); ++i) {
        add_point(without_underflow(points[i]), static_cast<std::uint16_t>(i), near);
    }
    collect();
    return Status::kOk;
}

}  // namespace facet
