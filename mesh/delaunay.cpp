// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/delaunay.h"

#include <algorithm>
#include <cmath>

#include "mesh/predicates.h"

namespace facet {
namespace {

constexpr double kMaxCoordinate = 1e9;
constexpr std::int16_t kOutside = -1;
constexpr std::int16_t kNotVisited = -2;

bool are_in_range(std::span<const Eigen::Vector2d> points) {
    return std::all_of(points.begin(), points.end(), [](const Eigen::Vector2d& p) {
        return std::abs(p.x()) <= kMaxCoordinate && std::abs(p.y()) <= kMaxCoordinate;
    });
}

}  // namespace

bool Delaunay::left_of(std::uint16_t p, Edge e) const {
    return orientation(at(p), at(origin_[e]), at(destination(e))) > 0.0;
}

bool Delaunay::right_of(std::uint16_t p, Edge e) const {
    return orientation(at(p), at(destination(e)), at(origin_[e])) > 0.0;
}

template <class Point>
bool Delaunay::is_before(Axis axis, const Point& a, const Point& b) {
    if (axis == Axis::kX) {
        return a.x != b.x ? a.x < b.x : a.y < b.y;
    }
    return a.y != b.y ? a.y < b.y : a.x > b.x;
}

/// Equal points are merged into the first; the others arranged for build().
void Delaunay::sort(std::span<const Eigen::Vector2d> points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        keys_[i] = {points[i].x(), points[i].y(), static_cast<std::uint16_t>(i)};
    }
    const auto end = keys_.begin() + static_cast<std::ptrdiff_t>(points.size());
    std::sort(keys_.begin(), end, [](const Key& a, const Key& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.index < b.index;
    });
    const auto last =
        std::unique(keys_.begin(), end, [](const Key& a, const Key& b) { return a.x == b.x && a.y == b.y; });
    count_ = static_cast<int>(last - keys_.begin());
    duplicates_ = static_cast<int>(points.size()) - count_;
    arrange(0, count_, Axis::kY);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
        sorted_[i] = {keys_[i].x, keys_[i].y};
        index_[i] = keys_[i].index;
    }
}

/// Halves by cuts across alternating axes, down to two or three points in order. Recursion depth: log2(kMaxMeshPoints).
// NOLINTNEXTLINE(misc-no-recursion)
void Delaunay::arrange(int first, int count, Axis axis) {
    const auto begin = keys_.begin() + first;
    if (count <= 3) {
        std::sort(begin, begin + count, [axis](const Key& a, const Key& b) { return is_before(axis, a, b); });
        return;
    }
    const Axis cut = other(axis);
    const int half = count / 2;
    std::nth_element(begin, begin + half, begin + count,
                     [cut](const Key& a, const Key& b) { return is_before(cut, a, b); });
    arrange(first, half, cut);
    arrange(first + half, count - half, cut);
}

Delaunay::Edge Delaunay::make_edge(std::uint16_t from, std::uint16_t to) {
    Edge e = 0;
    if (free_.empty()) {
        e = static_cast<Edge>(edges_);
        edges_ += 2;
        FACET_ASSERT(edges_ <= kMaxEdges);
    } else {
        e = free_.back();
        free_.pop_back();
    }
    const Edge r = reverse(e);
    origin_[e] = from;
    origin_[r] = to;
    next_[e] = previous_[e] = e;
    next_[r] = previous_[r] = r;
    alive_[e] = alive_[r] = true;
    left_face_[e] = left_face_[r] = kNotVisited;
    return e;
}

/// Joins the rings of two edges if they are different, separates them if they are one.
void Delaunay::splice(Edge a, Edge b) {
    std::swap(next_[a], next_[b]);
    previous_[next_[a]] = a;
    previous_[next_[b]] = b;
}

/// New edge from a's destination to b's origin, with the same left face as both.
Delaunay::Edge Delaunay::connect(Edge a, Edge b) {
    const Edge e = make_edge(destination(a), origin_[b]);
    splice(e, left_next(a));
    splice(reverse(e), b);
    return e;
}

void Delaunay::remove(Edge e) {
    const Edge r = reverse(e);
    splice(e, previous_[e]);
    splice(r, previous_[r]);
    alive_[e] = alive_[r] = false;
    free_.push_back(static_cast<Edge>(e & ~1U));
}

Delaunay::Hull Delaunay::build_three(std::uint16_t first) {
    const auto second = static_cast<std::uint16_t>(first + 1);
    const auto third = static_cast<std::uint16_t>(first + 2);
    const Edge a = make_edge(first, second);
    const Edge b = make_edge(second, third);
    splice(reverse(a), b);
    const double turn = orientation(at(first), at(second), at(third));
    if (turn == 0.0) {
        return {a, reverse(b)};
    }
    const Edge c = connect(b, a);
    return turn > 0.0 ? Hull{a, reverse(b)} : Hull{reverse(c), c};
}

/// The two halves are joined across the cut that arrange() made. @param axis  along which the hull's ends are wanted
// NOLINTNEXTLINE(misc-no-recursion)
Delaunay::Hull Delaunay::build(int first, int count, Axis axis) {
    if (count == 2) {
        const Edge e = make_edge(static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(first + 1));
        return {e, reverse(e)};
    }
    if (count == 3) {
        return build_three(static_cast<std::uint16_t>(first));
    }
    const int half = count / 2;
    const Axis cut = other(axis);
    const Hull left = build(first, half, cut);
    return ends_along(axis, merge(left, build(first + half, count - half, cut)).left);
}

/// Once around the outside, counterclockwise.
Delaunay::Hull Delaunay::ends_along(Axis axis, Edge on_hull) const {
    struct Place {
        double x;
        double y;
    };
    const auto place = [this](std::uint16_t rank) { return Place{at(rank).x(), at(rank).y()}; };
    Edge out_of_first = on_hull;
    Edge into_last = on_hull;
    for (Edge e = right_previous(on_hull); e != on_hull; e = right_previous(e)) {
        out_of_first = is_before(axis, place(origin_[e]), place(origin_[out_of_first])) ? e : out_of_first;
        into_last = is_before(axis, place(destination(into_last)), place(destination(e))) ? e : into_last;
    }
    return {out_of_first, reverse(into_last)};
}

/// Deletes edges on one side of the base that fail the circle test, from `first` on; the next candidate there.
/// @param following  next_ for the left side, previous_ for the right one
Delaunay::Candidate Delaunay::candidate(Edge base, Edge first, const std::array<Edge, kMaxEdges>& following) {
    if (!right_of(destination(first), base)) {
        return {first, false};
    }
    Edge edge = first;
    while (in_circle(at(destination(base)), at(origin_[base]), at(destination(edge)),
                     at(destination(following[edge]))) > 0.0) {
        const Edge next = following[edge];
        remove(edge);
        edge = next;
    }
    return {edge, edge == first || right_of(destination(edge), base)};
}

Delaunay::Hull Delaunay::merge(Hull l, Hull r) {
    Edge left = l.right;  // towards the other half
    Edge right = r.left;
    for (bool moved = true; moved;) {  // down to the lower common tangent
        moved = true;
        if (left_of(origin_[right], left)) {
            left = left_next(left);
        } else if (right_of(origin_[left], right)) {
            right = right_previous(right);
        } else {
            moved = false;
        }
    }
    Edge base = connect(reverse(right), left);
    if (origin_[left] == origin_[l.left]) {
        l.left = reverse(base);
    }
    if (origin_[right] == origin_[r.right]) {
        r.right = base;
    }
    for (;;) {  // the rising bubble
        const auto [from_left, left_valid] = candidate(base, next_[reverse(base)], next_);
        const auto [from_right, right_valid] = candidate(base, previous_[base], previous_);
        if (!left_valid && !right_valid) {
            return {l.left, r.right};
        }
        const bool take_right =
            !left_valid || (right_valid && in_circle(at(destination(from_left)), at(origin_[from_left]),
                                                     at(origin_[from_right]), at(destination(from_right))) > 0.0);
        base = take_right ? connect(from_right, reverse(base)) : connect(reverse(base), reverse(from_left));
    }
}

/// Walks around the outside first; every other face is a triangle.
void Delaunay::collect() {
    triangles_.clear();
    const auto end = static_cast<Edge>(edges_);
    std::fill_n(left_face_.begin(), edges_, kNotVisited);
    const Edge begin = reverse(hull_);
    Edge outside = begin;
    do {
        left_face_[outside] = kOutside;
        outside = left_next(outside);
    } while (outside != begin);
    for (Edge e = 0; e < end; ++e) {
        if (!alive_[e] || left_face_[e] != kNotVisited) {
            continue;
        }
        const std::array<Edge, 3> side{e, left_next(e), left_next(left_next(e))};
        first_edge_[triangles_.size()] = e;
        for (const Edge s : side) {
            left_face_[s] = static_cast<std::int16_t>(triangles_.size());
        }
        triangles_.push_back({{origin_[side[0]], origin_[side[1]], origin_[side[2]]}, {}});
    }
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
        Triangle& t = triangles_[i];
        Edge e = first_edge_[i];
        for (std::size_t k = 0; k < 3; ++k) {
            t.point[k] = index_[t.point[k]];
            t.neighbour[k] = left_face_[reverse(e)];
            e = left_next(e);
        }
        const auto least = std::min_element(t.point.begin(), t.point.end()) - t.point.begin();
        std::rotate(t.point.begin(), t.point.begin() + least, t.point.end());
        std::rotate(t.neighbour.begin(), t.neighbour.begin() + least, t.neighbour.end());
    }
}

/// Turns the diagonal of the quadrilateral around an edge.
void Delaunay::swap(Edge e) {
    const Edge r = reverse(e);
    const Edge a = previous_[e];
    const Edge b = previous_[r];
    splice(e, a);
    splice(r, b);
    splice(e, left_next(a));
    splice(r, left_next(b));
    origin_[e] = destination(a);
    origin_[r] = destination(b);
}

/// A side of the triangle that holds a point, its left one, from an edge on; or of the outside, if it is not in the hull. In a
/// Delaunay triangulation such a walk never comes back to a triangle.
Delaunay::Edge Delaunay::locate(const Eigen::Vector2d& p, Edge from) const {
    const auto is_right_of = [&](Edge e) { return orientation(p, at(destination(e)), at(origin_[e])) > 0.0; };
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
        if (at(origin_[e]) == p) {
            ++duplicates_;
            return false;
        }
    }
    for (int k = 0; k < 3; ++k, e = left_next(e)) {
        if (orientation(p, at(origin_[e]), at(destination(e))) == 0.0) {
            if (left_face_[reverse(e)] == kOutside) {
                return false;
            }
            e = previous_[e];
            remove(next_[e]);
            break;
        }
    }
    const auto rank = static_cast<std::uint16_t>(count_++);
    sorted_[rank] = p;
    index_[rank] = index;
    Edge spoke = make_edge(origin_[e], rank);
    splice(spoke, e);
    near = spoke;
    do {
        spoke = connect(e, reverse(spoke));
        e = previous_[spoke];
    } while (left_next(e) != near);
    for (;;) {
        const std::uint16_t beyond = destination(previous_[e]);
        if (left_face_[reverse(e)] != kOutside && right_of(beyond, e) &&
            in_circle(at(origin_[e]), at(beyond), at(destination(e)), p) > 0.0) {
            swap(e);
            e = previous_[e];
        } else if (next_[e] == near) {
            return true;
        } else {
            e = left_previous(next_[e]);
        }
    }
}

Status Delaunay::insert(std::span<const Eigen::Vector2d> points) {
    if (points.size() > static_cast<std::size_t>(kMaxMeshPoints)) {
        return Status::kFull;
    }
    if (points.size() < static_cast<std::size_t>(points_) || !are_in_range(points)) {
        return Status::kInvalidArgument;
    }
    const auto first = static_cast<std::size_t>(points_);
    points_ = static_cast<int>(points.size());
    if (triangles_.empty() || first == points.size()) {
        return Status::kOk;
    }
    Edge near = hull_;
    for (std::size_t i = first; i < points.size(); ++i) {
        add_point(points[i], static_cast<std::uint16_t>(i), near);
    }
    collect();
    return Status::kOk;
}

Status Delaunay::triangulate(std::span<const Eigen::Vector2d> points) {
    triangles_.clear();
    free_.clear();
    edges_ = 0;
    points_ = 0;
    duplicates_ = 0;
    if (points.size() > static_cast<std::size_t>(kMaxMeshPoints)) {
        return Status::kFull;
    }
    if (!are_in_range(points)) {
        return Status::kInvalidArgument;
    }
    points_ = static_cast<int>(points.size());
    sort(points);
    if (count_ >= 3) {
        hull_ = build(0, count_, Axis::kY).left;
        collect();
    }
    return Status::kOk;
}

}  // namespace facet
