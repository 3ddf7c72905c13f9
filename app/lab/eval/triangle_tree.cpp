// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/triangle_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace facet {
namespace {

constexpr int kLeaf = 4;
constexpr int kMaxDepth = 64;

double box_distance(const Eigen::Vector3f& low, const Eigen::Vector3f& high, const Eigen::Vector3d& p) {
    return (low.cast<double>() - p).cwiseMax(p - high.cast<double>()).cwiseMax(0.0).norm();
}

/// Parameter at which the ray a + t d meets the triangle, or -1. [Moeller97]
double hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& d, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
           const Eigen::Vector3d& c) {
    const Eigen::Vector3d e1 = b - a;
    const Eigen::Vector3d e2 = c - a;
    const Eigen::Vector3d h = d.cross(e2);
    const double det = e1.dot(h);
    if (std::abs(det) < 1e-14) {
        return -1.0;
    }
    const Eigen::Vector3d s = origin - a;
    const double u = s.dot(h) / det;
    const Eigen::Vector3d q = s.cross(e1);
    const double v = d.dot(q) / det;
    return u < 0.0 || v < 0.0 || u + v > 1.0 ? -1.0 : e2.dot(q) / det;
}

}  // namespace

Eigen::Vector3d TriangleSoup::normal(std::size_t triangle) const {
    const Eigen::Vector3d n =
        (corner(triangle, 1) - corner(triangle, 0)).cross(corner(triangle, 2) - corner(triangle, 0));
    return n.norm() > 0.0 ? n.normalized() : Eigen::Vector3d::Zero();
}

double TriangleSoup::area(std::size_t triangle) const {
    return 0.5 * (corner(triangle, 1) - corner(triangle, 0)).cross(corner(triangle, 2) - corner(triangle, 0)).norm();
}

Eigen::Vector3d nearest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c) {
    const Eigen::Vector3d n = (b - a).cross(c - a);
    const double nn = n.squaredNorm();
    const std::array<const Eigen::Vector3d*, 3> corner{&a, &b, &c};
    bool inside = nn > 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3d& from = *corner[k];
        inside = inside && n.dot((*corner[(k + 1) % 3] - from).cross(p - from)) >= 0.0;
    }
    if (inside) {
        return p - (n.dot(p - a) / nn) * n;
    }
    Eigen::Vector3d best = a;
    for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3d& from = *corner[k];
        const Eigen::Vector3d side = *corner[(k + 1) % 3] - from;
        const double t = std::clamp(side.dot(p - from) / std::max(side.squaredNorm(), 1e-300), 0.0, 1.0);
        const Eigen::Vector3d q = from + t * side;
        best = (p - q).squaredNorm() < (p - best).squaredNorm() ? q : best;
    }
    return best;
}

TriangleTree::TriangleTree(const TriangleSoup& soup) : soup_(soup), items_(soup.triangles.size()) {
    std::iota(items_.begin(), items_.end(), 0);
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        centres_.push_back(((soup.corner(i, 0) + soup.corner(i, 1) + soup.corner(i, 2)) / 3.0).cast<float>());
    }
    nodes_.reserve(soup.triangles.size() + 1);
    nodes_.emplace_back();
    split(0, 0, static_cast<int>(items_.size()));
}

// Recursion depth: log2 of the number of triangles.
// NOLINTNEXTLINE(misc-no-recursion)
void TriangleTree::split(int node, int first, int count) {
    Eigen::Vector3f low = Eigen::Vector3f::Constant(1e30F);
    Eigen::Vector3f high = -low;
    Eigen::Vector3f centre_low = low;
    Eigen::Vector3f centre_high = high;
    for (int i = first; i < first + count; ++i) {
        const auto t = static_cast<std::size_t>(items_[static_cast<std::size_t>(i)]);
        for (int k = 0; k < 3; ++k) {
            low = low.cwiseMin(soup_.corner(t, k).cast<float>() - Eigen::Vector3f::Constant(1e-4F));
            high = high.cwiseMax(soup_.corner(t, k).cast<float>() + Eigen::Vector3f::Constant(1e-4F));
        }
        centre_low = centre_low.cwiseMin(centres_[t]);
        centre_high = centre_high.cwiseMax(centres_[t]);
    }
    nodes_[static_cast<std::size_t>(node)] = {low, high, first, count};
    if (count <= kLeaf) {
        return;
    }
    int axis = 0;
    (centre_high - centre_low).maxCoeff(&axis);
    const auto begin = items_.begin() + first;
    std::nth_element(begin, begin + count / 2, begin + count, [&](int a, int b) {
        return centres_[static_cast<std::size_t>(a)][axis] < centres_[static_cast<std::size_t>(b)][axis];
    });
    const auto child = static_cast<int>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[static_cast<std::size_t>(node)].first = child;
    nodes_[static_cast<std::size_t>(node)].count = 0;
    split(child, first, count / 2);
    split(child + 1, first + count / 2, count - count / 2);
}

TriangleTree::Nearest TriangleTree::nearest(const Eigen::Vector3d& p, double limit) const {
    Nearest best{limit, p, -1};
    std::array<std::pair<double, int>, 2 * kMaxDepth> stack;
    std::size_t depth = 0;
    if (!items_.empty()) {
        stack[depth++] = {box_distance(nodes_[0].low, nodes_[0].high, p), 0};
    }
    while (depth > 0) {
        const auto [distance, index] = stack[--depth];
        const Node& node = nodes_[static_cast<std::size_t>(index)];
        if (distance >= best.distance) {
            continue;
        }
        if (node.count == 0) {
            std::array<std::pair<double, int>, 2> child;
            for (int k = 0; k < 2; ++k) {
                const Node& c = nodes_[static_cast<std::size_t>(node.first + k)];
                child[static_cast<std::size_t>(k)] = {box_distance(c.low, c.high, p), node.first + k};
            }
            const bool swap = child[0].first < child[1].first;
            stack[depth++] = child[swap ? 1 : 0];
            stack[depth++] = child[swap ? 0 : 1];
            continue;
        }
        for (int i = node.first; i < node.first + node.count; ++i) {
            const int t = items_[static_cast<std::size_t>(i)];
            const auto u = static_cast<std::size_t>(t);
            const Eigen::Vector3d q =
                nearest_on_triangle(p, soup_.corner(u, 0), soup_.corner(u, 1), soup_.corner(u, 2));
            if ((p - q).norm() < best.distance) {
                best = {(p - q).norm(), q, t};
            }
        }
    }
    return best;
}

/// Parameter of the first hit below the limit, or with kAny of some hit; the limit if there is none.
template <bool kAny>
double TriangleTree::hit_before(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double limit) const {
    const Eigen::Vector3d inverse = direction.cwiseInverse();
    std::array<int, 2 * kMaxDepth> stack{};
    std::size_t depth = items_.empty() ? 0 : 1;
    double best = limit;
    while (depth > 0) {
        const Node& node = nodes_[static_cast<std::size_t>(stack[--depth])];
        const Eigen::Vector3d t0 = (node.low.cast<double>() - origin).cwiseProduct(inverse);
        const Eigen::Vector3d t1 = (node.high.cast<double>() - origin).cwiseProduct(inverse);
        if (std::max(0.0, t0.cwiseMin(t1).maxCoeff()) > std::min(best, t0.cwiseMax(t1).minCoeff())) {
            continue;
        }
        if (node.count == 0) {
            stack[depth++] = node.first;
            stack[depth++] = node.first + 1;
            continue;
        }
        for (int i = node.first; i < node.first + node.count; ++i) {
            const auto t = static_cast<std::size_t>(items_[static_cast<std::size_t>(i)]);
            const double at = hit(origin, direction, soup_.corner(t, 0), soup_.corner(t, 1), soup_.corner(t, 2));
            if (at > 1e-6 && at < best) {
                best = at;
                if (kAny) {
                    return best;
                }
            }
        }
    }
    return best;
}

bool TriangleTree::blocks(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double margin_m) const {
    const double end = 1.0 - margin_m / std::max((b - a).norm(), 1e-9);
    return hit_before<true>(a, b - a, end) < end;
}

double TriangleTree::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double limit) const {
    return hit_before<false>(origin, direction, limit);
}

}  // namespace facet
