// SPDX-License-Identifier: BSD-2-Clause
// The edges of a planar graph, in rings around its points.
#pragma once

#include <array>
#include <cstdint>
#include <utility>

#include "mesh/capacity.h"
#include "platform/base/assert.h"
#include "platform/base/fixed_vector.h"

namespace facet {

/// Directed edges in pairs, edge e and its reverse e ^ 1; those that leave a point form a ring, counterclockwise
/// [Guibas85, for a plane without its dual]. Points are numbers; the caller keeps their positions. Up to
/// kMaxMeshPoints points: a planar graph of n points has at most 3n - 6 pairs of edges. Thread-bound. No heap.
class EdgeRings {
public:
    using Edge = std::uint16_t;
    static constexpr int kMaxEdges = 6 * kMaxMeshPoints;  ///< directed

    void clear() {
        free_.clear();
        end_ = 0;
    }

    /// One behind the last edge ever made; those below may be dead.
    Edge end() const { return end_; }
    bool is_alive(Edge e) const { return alive_[e]; }

    static Edge reverse(Edge e) { return static_cast<Edge>(e ^ 1U); }
    std::uint16_t origin(Edge e) const { return origin_[e]; }
    std::uint16_t destination(Edge e) const { return origin_[reverse(e)]; }
    Edge next(Edge e) const { return next_[e]; }          ///< counterclockwise around the origin
    Edge previous(Edge e) const { return previous_[e]; }  ///< clockwise
    /// Along the face on the left, counterclockwise and clockwise.
    Edge left_next(Edge e) const { return previous_[reverse(e)]; }
    Edge left_previous(Edge e) const { return reverse(next_[e]); }
    /// Along the face on the right, counterclockwise.
    Edge right_previous(Edge e) const { return next_[reverse(e)]; }

    /// Makes an edge that is connected to no other.
    Edge make_edge(std::uint16_t from, std::uint16_t to) {
        Edge e = end_;
        if (free_.empty()) {
            FACET_ASSERT(end_ + 2 <= kMaxEdges);
            end_ = static_cast<Edge>(end_ + 2);
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
    void splice(Edge a, Edge b) {
        std::swap(next_[a], next_[b]);
        previous_[next_[a]] = a;
        previous_[next_[b]] = b;
    }

    /// New edge from a's destination to b's origin, with the same left face as both.
    Edge connect(Edge a, Edge b) {
        const Edge e = make_edge(destination(a), origin(b));
        splice(e, left_next(a));
        splice(reverse(e), b);
        return e;
    }

    void remove(Edge e) {
        const Edge r = reverse(e);
        splice(e, previous_[e]);
        splice(r, previous_[r]);
        alive_[e] = alive_[r] = false;
        free_.push_back(static_cast<Edge>(e & ~1U));
    }

    /// Turns an edge between two triangles to the other diagonal of their quadrilateral.
    void turn(Edge e) {
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

private:
    Edge end_ = 0;
    FixedVector<Edge, kMaxEdges> free_;
    std::array<std::uint16_t, kMaxEdges> origin_{};  ///< point that an edge leaves
    std::array<Edge, kMaxEdges> next_{};
    std::array<Edge, kMaxEdges> previous_{};
    std::array<bool, kMaxEdges> alive_{};
};

}  // namespace facet
