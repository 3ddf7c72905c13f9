// SPDX-License-Identifier: BSD-2-Clause
// Bounding volume hierarchy over primitives, traversed by packets of four rays.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "app/lab/sim/primitives.h"

namespace facet::sim {

/// Binary tree of boxes, split by the surface-area heuristic. build() uses the heap; queries do not and are reentrant.
class Bvh {
public:
    void build(std::span<const SurfaceShape> surfaces);

    /// Nearest hits of four rays: see RayPacket. Directions must be unit length.
    void intersect(RayPacket& packet) const;

    static constexpr int kMaxBundle = 64;  ///< packets

    /// The same for neighbouring rays, at most kMaxBundle packets at once: boxes that the whole bundle misses are ruled
    /// out by interval arithmetic, and boxes are entered with the first packet that hits. Wald, Boulos, Shirley, "Ray
    /// tracing deformable scenes using dynamic bounding volume hierarchies", TOG 2007.
    void intersect_bundle(std::span<RayPacket> packets) const;

    /// Distance from a point to the nearest surface, at most `limit` (m).
    double distance(std::span<const SurfaceShape> surfaces, const Eigen::Vector3d& p, double limit) const;

    /// Primitives in tree order: RayPacket::primitive counts in it.
    std::span<const Primitive> primitives() const { return primitives_; }

private:
    struct Node {
        float low[3];
        std::int32_t first;  ///< leaf: first primitive; else: left child, the right one follows
        float high[3];
        std::int16_t count;  ///< leaf: number of primitives; else 0
        std::int16_t axis;   ///< of the split
    };
    struct Item {
        Box box;
        Eigen::Vector3f centre;
        std::uint32_t surface;
    };

    struct Split {
        int axis = -1;  ///< -1: better a leaf
        int bin = 0;    ///< last bin of the left side
    };
    /// Centres of a node's items fall into equal bins along each axis.
    struct Bins {
        Eigen::Vector3f low;
        Eigen::Vector3f high;
        int of(const Item& item, int axis) const;
    };

    static Split find_split(std::span<const Item> items, const Bins& bins, float node_area);
    void split(std::span<Item> items, int first, int node, int depth);
    static bool touches(const Node& node, const V4& origin, const V4& inverse, F4 t);

    std::vector<Node> nodes_;
    std::vector<Primitive> primitives_;
};

}  // namespace facet::sim
