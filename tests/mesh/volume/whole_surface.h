// SPDX-License-Identifier: BSD-2-Clause
// The surface of all blocks of a volume.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "mesh/volume/surface_nets.h"

namespace facet::test {

/// Vertices once, by their cells.
struct WholeSurface {
    std::vector<SurfaceVertex> vertices;
    std::vector<std::array<int, 3>> triangles;
    std::uint16_t views = 0;  ///< most of any triangle
    float apart_m = 0.0F;     ///< farthest that two blocks' vertices of one cell are from one another

    void add(const SurfacePiece& piece) {
        std::vector<int> index;
        for (const SurfaceVertex& v : piece.vertices) {
            const std::array<int, 3> cell{8 * piece.at.x() + v.cell[0], 8 * piece.at.y() + v.cell[1],
                                          8 * piece.at.z() + v.cell[2]};
            const auto [at, is_new] = index_.try_emplace(cell, static_cast<int>(vertices.size()));
            if (is_new) {
                vertices.push_back(v);
            }
            apart_m = std::max(apart_m, (vertices[static_cast<std::size_t>(at->second)].p_W - v.p_W).norm());
            index.push_back(at->second);
        }
        for (const SurfaceTriangle& t : piece.triangles) {
            triangles.push_back({index[t.vertex[0]], index[t.vertex[1]], index[t.vertex[2]]});
            views = std::max(views, t.views);
        }
    }
    double area() const {
        double sum = 0.0;
        for (const auto& t : triangles) {
            const auto p = [&](std::size_t k) { return vertices[static_cast<std::size_t>(t[k])].p_W; };
            sum += 0.5 * static_cast<double>((p(1) - p(0)).cross(p(2) - p(0)).norm());
        }
        return sum;
    }

private:
    std::map<std::array<int, 3>, int> index_;
};

inline WholeSurface whole_surface(const TsdfVolume& volume, const SurfaceOptions& options = {}) {
    WholeSurface surface;
    const auto nets = std::make_unique<SurfaceNets>(options);
    const auto piece = std::make_unique<SurfacePiece>();
    for (std::size_t slot = 0; slot < volume.slot_end(); ++slot) {
        if (volume.block(slot).is_used) {
            nets->extract(volume, slot, *piece);
            surface.add(*piece);
        }
    }
    return surface;
}

}  // namespace facet::test
