// SPDX-License-Identifier: BSD-2-Clause
// Triangles in a tree of boxes: nearest point and line of sight.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace facet {

/// Triangles by index into shared vertices (m).
struct TriangleSoup {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Eigen::Vector3i> triangles;

    const Eigen::Vector3d& corner(std::size_t triangle, int k) const {
        return vertices[static_cast<std::size_t>(triangles[triangle][k])];
    }
    Eigen::Vector3d normal(std::size_t triangle) const;  ///< unit, or zero without area
    double area(std::size_t triangle) const;
};

/// Nearest point of a triangle to p. Reentrant.
Eigen::Vector3d nearest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c);

/// Binary tree, split at the median of the longest axis. Heap in the constructor only; queries are reentrant.
class TriangleTree {
public:
    /// The soup must outlive the tree.
    explicit TriangleTree(const TriangleSoup& soup);

    struct Nearest {
        double distance;  ///< the limit if nothing is nearer
        Eigen::Vector3d point;
        int triangle = -1;
    };
    Nearest nearest(const Eigen::Vector3d& p, double limit) const;

    /// Whether any triangle crosses the segment from a to b, the last `margin_m` before b aside.
    bool blocks(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double margin_m) const;

    /// Where a ray meets the first triangle: origin + t direction, 0 < t < limit; the limit if it meets none.
    double cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double limit) const;

private:
    template <bool kAny>
    double hit_before(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double limit) const;
    struct Node {
        Eigen::Vector3f low;
        Eigen::Vector3f high;
        int first = 0;  ///< leaf: first item; else: left child, the right one follows
        int count = 0;  ///< leaf: items; else 0
    };
    void split(int node, int first, int count);

    const TriangleSoup& soup_;
    std::vector<int> items_;
    std::vector<Eigen::Vector3f> centres_;
    std::vector<Node> nodes_;
};

}  // namespace facet
