// SPDX-License-Identifier: BSD-2-Clause
// The surface of a signed distance field as a mesh.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mesh/volume/tsdf_volume.h"

namespace facet {

struct FusedMesh {
    std::vector<Eigen::Vector3f> vertices;   ///< (m)
    std::vector<Eigen::Vector3f> normals;    ///< of the vertices, into free space
    std::vector<Eigen::Vector3i> triangles;  ///< counterclockwise as seen from free space
    std::vector<std::int32_t> observations;  ///< of each triangle: views that measured it
    std::vector<float> sigmas;               ///< of each triangle, along its normal, if its views erred apart (m)
};

/// What counts as surface.
struct SurfaceOptions {
    double max_sigma_m = 0.03;  ///< of the mean over the views
    int min_views = 1;
    /// Views that saw through it, for each one that measured it. Wrong depths are mostly those of a foreground, alike
    /// in all views from one side; depths behind the true surface are rare. So few views through outweigh many.
    double max_through = 0.1;
    double min_piece_m2 = 0.03;  ///< smaller pieces that hang together with nothing are left out
};

/// Surface nets [Gibson98]: a vertex in every cell of eight voxels that the surface passes, at the mean of where it
/// crosses the cell's edges, and two triangles across every edge that it crosses. Where the distance jumps from one
/// voxel to the next by more than they are apart, two surfaces meet in sight but not in space: that is no crossing.
/// Heap. Reentrant. Deterministic.
FusedMesh extract_surface(const TsdfVolume& volume, const SurfaceOptions& options);

}  // namespace facet
