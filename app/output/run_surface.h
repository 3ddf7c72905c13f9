// SPDX-License-Identifier: BSD-2-Clause
// The surface of a whole run as one mesh, and its file.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "app/output/surface_planes.h"
#include "mesh/volume/surface_map.h"
#include "mesh/volume/surface_nets.h"

namespace facet {

struct SurfaceMesh {
    std::vector<Eigen::Vector3f> vertices;  ///< (m)
    std::vector<Eigen::Vector3f> normals;   ///< of the vertices, into free space
    std::vector<std::uint8_t> greys;        ///< of the vertices
    std::vector<Eigen::Vector3i> triangles;
    std::vector<std::int32_t> observations;  ///< of each triangle: views that measured it
    std::vector<float> sigmas;               ///< of each triangle, along its normal, if its views erred apart (m)
};

/// Keeps the newest piece of each block of a map, also of blocks that the map has given up since. When full, new blocks
/// are dropped and counted; those already there can still be replaced. Heap. Thread-bound.
class RunSurface final : public SurfaceSink {
public:
    explicit RunSurface(std::size_t max_triangles = std::numeric_limits<std::size_t>::max())
        : max_triangles_(max_triangles) {}

    void take(const SurfacePiece& piece, std::uint32_t restart) override;

    /// The pieces, joined where they meet.
    /// @param least_m2  smaller pieces of surface that hang together with nothing are left out
    SurfaceMesh mesh(double least_m2 = 0.03) const;
    /// The mesh as PLY, its vertices coloured by their grey. Throws InputError if it cannot be written.
    void write(const std::string& path, const std::string& comment, const SurfacePlanes& planes = {}) const;

    std::size_t triangles() const { return triangles_; }
    std::size_t dropped() const { return dropped_; }

private:
    using Key = std::array<std::int32_t, 4>;  ///< restart, block
    struct Piece {
        std::vector<SurfaceVertex> vertices;
        std::vector<SurfaceTriangle> triangles;
    };

    std::size_t max_triangles_;
    std::size_t triangles_ = 0;
    std::size_t dropped_ = 0;
    std::map<Key, Piece> pieces_;
};

}  // namespace facet
