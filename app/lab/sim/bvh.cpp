// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/bvh.h"

#include <algorithm>
#include <array>

#include "platform/base/assert.h"

namespace facet::sim {
namespace {

constexpr int kBins = 16;
constexpr int kMaxDepth = 60;
constexpr int kMaxLeaf = 4;

Box box_around(auto begin, auto end) {
    Box box;
    for (auto it = begin; it != end; ++it) {
        box.include(it->box);
    }
    return box;
}

V4 inverse_of(const V4& d) {
    const auto inverse = [](F4 x) { return 1.0F / (((x > -1e-12F) & (x < 1e-12F)) ? splat(1e-12F) : x); };
    return {inverse(d.x), inverse(d.y), inverse(d.z)};
}

/// Intervals of the origins and inverse directions of a bundle of rays, for ruling out boxes that all of them miss. An
/// axis on which the directions differ in sign rules out nothing.
struct BundleBounds {
    F4 origin_low[3] = {splat(1e30F), splat(1e30F), splat(1e30F)};
    F4 origin_high[3] = {splat(-1e30F), splat(-1e30F), splat(-1e30F)};
    F4 inverse_low[3] = {splat(1e30F), splat(1e30F), splat(1e30F)};
    F4 inverse_high[3] = {splat(-1e30F), splat(-1e30F), splat(-1e30F)};
    float near_origin[3];  ///< the origin that meets the box last, forward along the axis
    float far_origin[3];
    float slow[3];  ///< least and largest |inverse direction|
    float fast[3];
    bool usable[3];
    bool backward[3];

    void include(const V4& origin, const V4& inverse) {
        const F4 o[3] = {origin.x, origin.y, origin.z};
        const F4 v[3] = {inverse.x, inverse.y, inverse.z};
        for (int k = 0; k < 3; ++k) {
            origin_low[k] = min4(origin_low[k], o[k]);
            origin_high[k] = max4(origin_high[k], o[k]);
            inverse_low[k] = min4(inverse_low[k], v[k]);
            inverse_high[k] = max4(inverse_high[k], v[k]);
        }
    }

    void finish() {
        const auto least = [](F4 a) { return std::min(std::min(a[0], a[1]), std::min(a[2], a[3])); };
        const auto most = [](F4 a) { return std::max(std::max(a[0], a[1]), std::max(a[2], a[3])); };
        for (int k = 0; k < 3; ++k) {
            const float low = least(inverse_low[k]);
            const float high = most(inverse_high[k]);
            backward[k] = high < 0.0F;
            usable[k] = low > 0.0F || backward[k];
            slow[k] = backward[k] ? -high : low;
            fast[k] = backward[k] ? -low : high;
            near_origin[k] = backward[k] ? least(origin_low[k]) : most(origin_high[k]);
            far_origin[k] = backward[k] ? most(origin_high[k]) : least(origin_low[k]);
        }
    }

    bool misses(const float* low, const float* high, float farthest) const {
        float enter = 0.0F;
        float leave = farthest;
        for (int k = 0; k < 3; ++k) {
            if (!usable[k]) {
                continue;
            }
            const float a = backward[k] ? near_origin[k] - high[k] : low[k] - near_origin[k];
            const float b = backward[k] ? far_origin[k] - low[k] : high[k] - far_origin[k];
            enter = std::max(enter, a * (a >= 0.0F ? slow[k] : fast[k]));
            leave = std::min(leave, b * (b >= 0.0F ? fast[k] : slow[k]));
        }
        return enter > leave;
    }
};

}  // namespace

void Bvh::build(std::span<const SurfaceShape> surfaces) {
    FACET_ASSERT(!surfaces.empty());
    std::vector<Item> items;
    items.reserve(surfaces.size());
    for (std::uint32_t i = 0; i < surfaces.size(); ++i) {
        const Box box = surface_box(surfaces[i]);
        items.push_back({box, 0.5F * (box.low + box.high), i});
    }
    nodes_.assign(1, Node{});
    nodes_.reserve(2 * items.size());
    split(items, 0, 0, 0);
    primitives_.clear();
    for (const Item& item : items) {
        primitives_.push_back(make_primitive(surfaces[item.surface], item.surface));
    }
}

int Bvh::Bins::of(const Item& item, int axis) const {
    const float place = (item.centre[axis] - low[axis]) / (high[axis] - low[axis]);
    return std::clamp(static_cast<int>(place * kBins), 0, kBins - 1);
}

/// Binned surface-area heuristic: the split with least sum of area times count. Wald, "On fast construction of
/// SAH-based bounding volume hierarchies", 2007.
Bvh::Split Bvh::find_split(std::span<const Item> items, const Bins& bins, float node_area) {
    const auto count = static_cast<int>(items.size());
    const bool must = count > kMaxLeaf;
    Split best;
    float best_cost = static_cast<float>(count) * node_area;
    for (int axis = 0; axis < 3; ++axis) {
        if (bins.high[axis] - bins.low[axis] < 1e-6F) {
            continue;
        }
        std::array<Box, kBins> boxes;
        std::array<int, kBins> counts{};
        for (const Item& item : items) {
            const int bin = bins.of(item, axis);
            boxes[bin].include(item.box);
            ++counts[bin];
        }
        std::array<float, kBins> right_cost{};
        Box right;
        int right_count = 0;
        for (int i = kBins - 1; i > 0; --i) {
            right.include(boxes[i]);
            right_count += counts[i];
            right_cost[i] = right_count > 0 ? static_cast<float>(right_count) * right.half_area() : 0.0F;
        }
        Box left;
        int left_count = 0;
        for (int i = 0; i + 1 < kBins; ++i) {
            left.include(boxes[i]);
            left_count += counts[i];
            if (left_count == 0 || left_count == count) {
                continue;
            }
            const float cost = static_cast<float>(left_count) * left.half_area() + right_cost[i + 1] + node_area;
            if (cost < best_cost || (best.axis < 0 && must)) {
                best_cost = cost;
                best = {axis, i};
            }
        }
    }
    return best;
}

void Bvh::split(std::span<Item> items, int first, int node, int depth) {
    const Box box = box_around(items.begin(), items.end());
    Eigen::Map<Eigen::Vector3f>(nodes_[node].low) = box.low;
    Eigen::Map<Eigen::Vector3f>(nodes_[node].high) = box.high;
    nodes_[node].first = first;
    nodes_[node].count = static_cast<std::int16_t>(items.size());

    Bins bins{items[0].centre, items[0].centre};
    for (const Item& item : items) {
        bins.low = bins.low.cwiseMin(item.centre);
        bins.high = bins.high.cwiseMax(item.centre);
    }
    const Split best = items.size() > 1 && depth < kMaxDepth ? find_split(items, bins, box.half_area()) : Split{};
    if (best.axis < 0) {
        FACET_ASSERT(items.size() < 30000);
        return;
    }
    const auto middle = std::partition(items.begin(), items.end(),
                                       [&](const Item& item) { return bins.of(item, best.axis) <= best.bin; });
    const auto left_count = static_cast<int>(middle - items.begin());
    const auto child = static_cast<int>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[node].first = child;
    nodes_[node].count = 0;
    nodes_[node].axis = static_cast<std::int16_t>(best.axis);
    split(items.first(left_count), first, child, depth + 1);
    split(items.subspan(left_count), first + left_count, child + 1, depth + 1);
}

inline bool Bvh::touches(const Node& n, const V4& o, const V4& inv, F4 t) {
    const F4 x0 = (n.low[0] - o.x) * inv.x;
    const F4 x1 = (n.high[0] - o.x) * inv.x;
    const F4 y0 = (n.low[1] - o.y) * inv.y;
    const F4 y1 = (n.high[1] - o.y) * inv.y;
    const F4 z0 = (n.low[2] - o.z) * inv.z;
    const F4 z1 = (n.high[2] - o.z) * inv.z;
    const F4 enter = max4(max4(min4(x0, x1), min4(y0, y1)), max4(min4(z0, z1), splat(0.0F)));
    const F4 leave = min4(min4(max4(x0, x1), max4(y0, y1)), min4(max4(z0, z1), t));
    return any(enter <= leave);
}

void Bvh::intersect(RayPacket& packet) const {
    const V4 inv = inverse_of(packet.direction);
    const bool backward[3] = {packet.direction.x[0] < 0.0F, packet.direction.y[0] < 0.0F, packet.direction.z[0] < 0.0F};
    std::int32_t stack[kMaxDepth + 4];
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const Node* node = &nodes_[stack[--depth]];
        if (!touches(*node, packet.origin, inv, packet.t)) {
            continue;
        }
        while (node->count == 0) {
            const int near_child = node->first + (backward[node->axis] ? 1 : 0);
            const int far_child = node->first + (backward[node->axis] ? 0 : 1);
            if (touches(nodes_[near_child], packet.origin, inv, packet.t)) {
                stack[depth++] = far_child;
                node = &nodes_[near_child];
            } else if (touches(nodes_[far_child], packet.origin, inv, packet.t)) {
                node = &nodes_[far_child];
            } else {
                break;
            }
        }
        for (int i = node->first; i < node->first + node->count; ++i) {
            sim::intersect(primitives_[i], i, packet);
        }
    }
}

void Bvh::intersect_bundle(std::span<RayPacket> packets) const {
    const auto count = static_cast<int>(packets.size());
    FACET_ASSERT(count > 0 && count <= kMaxBundle);
    V4 inv[kMaxBundle];
    BundleBounds bounds;
    for (int i = 0; i < count; ++i) {
        inv[i] = inverse_of(packets[i].direction);
        bounds.include(packets[i].origin, inv[i]);
    }
    bounds.finish();
    struct Entry {
        std::int32_t node;
        std::int32_t first;  ///< no packet before this one hits the node
    };
    Entry stack[kMaxDepth + 4];
    int depth = 0;
    stack[depth++] = {0, 0};
    float farthest = RayPacket::kFar;
    while (depth > 0) {
        Entry entry = stack[--depth];
        const Node& node = nodes_[entry.node];
        if (bounds.misses(node.low, node.high, farthest)) {
            continue;
        }
        while (entry.first < count &&
               !touches(node, packets[entry.first].origin, inv[entry.first], packets[entry.first].t)) {
            ++entry.first;
        }
        if (entry.first == count) {
            continue;
        }
        if (node.count == 0) {
            const int near_side = bounds.backward[node.axis] ? 1 : 0;
            stack[depth++] = {node.first + 1 - near_side, entry.first};
            stack[depth++] = {node.first + near_side, entry.first};
            continue;
        }
        for (int k = entry.first; k < count; ++k) {
            if (k > entry.first && !touches(node, packets[k].origin, inv[k], packets[k].t)) {
                continue;
            }
            for (int i = node.first; i < node.first + node.count; ++i) {
                sim::intersect(primitives_[i], i, packets[k]);
            }
        }
        F4 t = packets[0].t;
        for (int k = 1; k < count; ++k) {
            t = max4(t, packets[k].t);
        }
        farthest = std::max(std::max(t[0], t[1]), std::max(t[2], t[3]));
    }
}

double Bvh::distance(std::span<const SurfaceShape> surfaces, const Eigen::Vector3d& p, double limit) const {
    const Eigen::Vector3f pf = p.cast<float>();
    std::int32_t stack[2 * kMaxDepth];
    int depth = 0;
    stack[depth++] = 0;
    double nearest = limit;
    while (depth > 0) {
        const Node& node = nodes_[stack[--depth]];
        const Eigen::Map<const Eigen::Vector3f> low(node.low);
        const Eigen::Map<const Eigen::Vector3f> high(node.high);
        const Eigen::Vector3f outside = (low - pf).cwiseMax(pf - high).cwiseMax(0.0F);
        if (outside.norm() > nearest) {
            continue;
        }
        if (node.count == 0) {
            stack[depth++] = node.first;
            stack[depth++] = node.first + 1;
            continue;
        }
        for (int i = node.first; i < node.first + node.count; ++i) {
            nearest = std::min(nearest, surface_distance(surfaces[primitives_[i].surface], p));
        }
    }
    return nearest;
}

}  // namespace facet::sim
