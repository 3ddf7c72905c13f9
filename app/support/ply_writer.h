// SPDX-License-Identifier: BSD-2-Clause
// Writes triangle meshes as binary little-endian PLY.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>

#include "platform/base/status.h"

namespace facet {

/// A triangle mesh with optional attributes: empty, or one for each vertex or triangle.
struct PlyMesh {
    std::span<const Eigen::Vector3f> vertices;                   ///< (m)
    std::span<const Eigen::Vector3f> normals;                    ///< of the vertices
    std::span<const Eigen::Matrix<std::uint8_t, 3, 1>> colours;  ///< red, green, blue of the vertices
    std::span<const Eigen::Vector3i> triangles;                  ///< indices into vertices
    std::span<const std::int32_t> planes;                        ///< plane of each triangle, -1 for none
    std::span<const std::int32_t> observations;                  ///< of each triangle
    std::span<const float> sigmas;                               ///< of each triangle, along its normal (m)
};

/// Writes `vertex` (float x y z [nx ny nz] [uchar red green blue]) and `face` (list uchar int vertex_indices [int
/// plane_id] [int observations] [float sigma]) elements. Errors as below.
Status write_ply(const std::string& path, const std::string& comment, const PlyMesh& mesh);

/// Writes `vertex` (float x y z, optionally uchar red green blue) and `face` (list uchar int vertex_indices) elements.
/// @param comment   one line for the header, may be empty
/// @param vertices  (m)
/// @param triangles indices into vertices
/// @param colours   red, green, blue of each vertex, or empty
/// @return kInvalidArgument if an index is out of range, colours do not match the vertices or the comment has a line
///         break (nothing written); kIo if the file cannot be written.
Status write_ply(const std::string& path, const std::string& comment, std::span<const Eigen::Vector3f> vertices,
                 std::span<const Eigen::Vector3i> triangles,
                 std::span<const Eigen::Matrix<std::uint8_t, 3, 1>> colours = {});

}  // namespace facet
