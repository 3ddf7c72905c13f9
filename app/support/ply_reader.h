// SPDX-License-Identifier: BSD-2-Clause
// Reads triangle meshes from PLY.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "platform/base/status.h"

namespace facet {

struct PlyTriangles {
    std::vector<Eigen::Vector3d> vertices;   ///< (m)
    std::vector<Eigen::Vector3i> triangles;  ///< indices into vertices
};

/// Reads vertices (x y z of any number type) and faces (a list named vertex_indices or vertex_index; polygons become
/// fans) of a PLY file, ASCII or binary little-endian; other elements and properties are skipped.
/// @param error  one line with the file's name on anything but kOk
/// @return kIo: cannot be read; kCorrupt: no PLY, truncated, an index out of range, or a coordinate that is not finite.
Status read_ply(const std::string& path, PlyTriangles& mesh, std::string& error);

}  // namespace facet
