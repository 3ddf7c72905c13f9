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

}  // namespace

bool Delaunay::left_of(std::uint16_t p, Edge e) const {
    return orientation(at(p), at(origin_[e]), at(destination(e))) > 0.0;
}

bool Delaunay::right_of(std::uint16_t p, Edge e) const {
    return orientation(at(p), at(destination(e)), at(origin_[e])) > 0.0;
}

/// Order by x, then y, then index; equal points are merged into the first.
void Delaunay::sort(std::span<const Eigen::Vector2d> points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        keys_[i] = {points[i].x(), points[i].y(), static_cast<std::uint16_t>(i)};
    }
    std::sort(keys_.begin(), keys_.begin() + static_cast<std::ptrdiff_t>(points.size()),
              [](const Key& a, const Key& b) {
                  return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.index < b.index;
              });
    count_ = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto n = static_cast<std::size_t>(count_);
        if (n > 0 && sorted_[n - 1].x() == keys_[i].x && sorted_[n - 1].y() == keys_[i].y) {
            continue;
        }
        sorted_[n] = {keys_[i].x, keys_[i].y};
        index_[n] = keys_[i].index;
        ++count_;
    }
    duplicates_ = static_cast<int>(points.size()) - count_;
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

/// Recursion depth: log2(kMaxMeshPoints).
// NOLINTNEXTLINE(misc-no-recursion)
Delaunay::Hull Delaunay::build(int first, int count) {
    if (count == 2) {
        const Edge e = make_edge(static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(first + 1));
        return {e, reverse(e)};
    }
    if (count == 3) {
        return build_three(static_cast<std::uint16_t>(first));
    }
    const int half = count / 2;
    const Hull left = build(first, half);
    return merge(left, build(first + half, count - half));
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
void Delaunay::collect(const Hull& hull) {
    const auto end = static_cast<Edge>(edges_);
    std::fill_n(left_face_.begin(), edges_, kNotVisited);
    const Edge begin = reverse(hull.left);
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

Status Delaunay::triangulate(std::span<const Eigen::Vector2d> points) {
    triangles_.clear();
    free_.clear();
    edges_ = 0;
    duplicates_ = 0;
    if (points.size() > static_cast<std::size_t>(kMaxMeshPoints)) {
        return Status::kFull;
    }
    for (const Eigen::Vector2d& p : points) {
        if (!(std::abs(p.x()) <= kMaxCoordinate && std::abs(p.y()) <= kMaxCoordinate)) {
            return Status::kInvalidArgument;
        }
    }
    sort(points);
    if (count_ >= 3) {
        collect(build(0, count_));
    }
    return Status::kOk;
}

}  // namespace facet
