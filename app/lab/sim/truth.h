// SPDX-License-Identifier: BSD-2-Clause
// The truth about a scene: its surface as triangles and its planes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/lab/sim/renderer.h"
#include "app/lab/sim/scene.h"

namespace facet::sim {

/// Triangles of a surface; curved shapes are divided so that the sagitta stays below `sagitta_m`. Vertices lie on the
/// surface.
struct TriangleMesh {
    std::vector<Eigen::Vector3f> vertices;
    std::vector<Eigen::Vector3i> triangles;
};
TriangleMesh tessellate(const Scene& scene, double sagitta_m = 0.002);

/// A true plane: normal . x = distance, the normal points into free space.
struct TruePlane {
    std::string name;
    Eigen::Vector3d normal;
    double distance = 0.0;
    double area = 0.0;         ///< of all its surfaces (m^2)
    double seen_area = 0.0;    ///< of the cells of about 0.1 m that the coarse pass has met (m^2)
    Eigen::Vector3d centroid;  ///< area-weighted
    Eigen::Vector3d low;
    Eigen::Vector3d high;
};

/// Planes of the scene's rectangles and disks from `min_area` on, largest seen first. Surfaces that are coplanar within
/// 25 mm and 0.5 degrees and whose boxes touch (a picture on its wall) are one plane with the name of the largest.
std::vector<TruePlane> true_planes(const Scene& scene, std::span<const CoarseHit> hits, double min_area = 0.01);

/// Writes OUT/truth/scene.ply, planes.json (format: mesh/README.md) and meta.json. @param failed on kIo the path
Status write_truth(const std::string& out, const Scene& scene, std::span<const CoarseHit> hits,
                   const std::string& meta_json, std::string& failed);

}  // namespace facet::sim
