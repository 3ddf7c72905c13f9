// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/delaunay.h"

#include <algorithm>
#include <cmath>

#include "mesh/predicates.h"

namespace facet {

Status Delaunay::check(std::span<const Eigen::Vector2d> points) {
    constexpr double kMaxCoordinate = 1e9;
    if (points.size() > static_cast<std::size_t>(kMaxMeshPoints)) {
        return Status::kFull;
    }
    const bool in_range = std::all_of(points.begin(), points.end(), [](const Eigen::Vector2d& p) {
        return std::abs(p.x()) <= kMaxCoordinate && std::abs(p.y()) <= kMaxCoordinate;
    });
    return in_range ? Status::kOk : Status::kInvalidArgument;
}

Eigen::Vector2d Delaunay::without_underflow(const Eigen::Vector2d& p) {
    constexpr double kLeast = 1e-60;  // predicates.h: their products of smaller numbers would underflow
    return (p.array().abs() < kLeast).select(0.0, p);
}

bool Delaunay::left_of(std::uint16_t p, Edge e) const {
    return orientation(at(p), at(origin(e)), at(destination(e))) > 0.0;
}

bool Delaunay::right_of(std::uint16_t p, Edge e) const {
    return orientation(at(p), at(destination(e)), at(origin(e))) > 0.0;
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
        const Eigen::Vector2d p = without_underflow(points[i]);
        keys_[i] = {p.x(), p.y(), static_cast<std::uint16_t>(i)};
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
        out_of_first = is_before(axis, place(origin(e)), place(origin(out_of_first))) ? e : out_of_first;
        into_last = is_before(axis, place(destination(into_last)), place(destination(e))) ? e : into_last;
    }
    return {out_of_first, reverse(into_last)};
}

/// Deletes edges on one side of the base that fail the circle test, from `first` on; the next candidate there.
/// @param following  next() for the left side, previous() for the right one
template <class Following>
Delaunay::Candidate Delaunay::candidate(Edge base, Edge first, Following following) {
    if (!right_of(destination(first), base)) {
        return {first, false};
    }
    Edge edge = first;
    while (in_circle(at(destination(base)), at(origin(base)), at(destination(edge)), at(destination(following(edge)))) >
           0.0) {
        const Edge successor = following(edge);
        remove(edge);
        edge = successor;
    }
    return {edge, edge == first || right_of(destination(edge), base)};
}

Delaunay::Hull Delaunay::merge(Hull l, Hull r) {
    Edge left = l.right;  // towards the other half
    Edge right = r.left;
    for (bool moved = true; moved;) {  // down to the lower common tangent
        moved = true;
        if (left_of(origin(right), left)) {
            left = left_next(left);
        } else if (right_of(origin(left), right)) {
            right = right_previous(right);
        } else {
            moved = false;
        }
    }
    Edge base = connect(reverse(right), left);
    if (origin(left) == origin(l.left)) {
        l.left = reverse(base);
    }
    if (origin(right) == origin(r.right)) {
        r.right = base;
    }
    const auto after = [this](Edge e) { return next(e); };
    const auto before = [this](Edge e) { return previous(e); };
    for (;;) {  // the rising bubble
        const auto [from_left, left_valid] = candidate(base, next(reverse(base)), after);
        const auto [from_right, right_valid] = candidate(base, previous(base), before);
        if (!left_valid && !right_valid) {
            return {l.left, r.right};
        }
        const bool take_right =
            !left_valid || (right_valid && in_circle(at(destination(from_left)), at(origin(from_left)),
                                                     at(origin(from_right)), at(destination(from_right))) > 0.0);
        base = take_right ? connect(from_right, reverse(base)) : connect(reverse(base), reverse(from_left));
    }
}

/// Walks around the outside first; every other face is a triangle.
void Delaunay::collect() {
    triangles_.clear();
    left_face_.fill(kNotVisited);  // those not made yet as well: insert() asks
    const Edge begin = reverse(hull_);
    Edge outside = begin;
    do {
        left_face_[outside] = kOutside;
        outside = left_next(outside);
    } while (outside != begin);
    for (Edge e = 0; e < end(); ++e) {
        if (!is_alive(e) || left_face_[e] != kNotVisited) {
            continue;
        }
        const std::array<Edge, 3> side{e, left_next(e), left_next(left_next(e))};
        first_edge_[triangles_.size()] = e;
        for (const Edge s : side) {
            left_face_[s] = static_cast<std::int16_t>(triangles_.size());
        }
        triangles_.push_back({{origin(side[0]), origin(side[1]), origin(side[2])}, {}});
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

Status Delaunay::triangulate(std::span<const Eigen::Vector2d> points) {
    triangles_.clear();
    clear();
    points_ = 0;
    duplicates_ = 0;
    FACET_TRY(check(points));
    points_ = static_cast<int>(points.size());
    sort(points);
    if (count_ >= 3) {
        hull_ = build(0, count_, Axis::kY).left;
        collect();
    }
    return Status::kOk;
}

}  // namespace facet
