// SPDX-License-Identifier: BSD-2-Clause
// The surface of a signed distance field as a mesh, a block at a time.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "mesh/volume/tsdf_volume.h"
#include "platform/base/fixed_vector.h"

namespace facet {

/// A point of the surface: one in a cell of eight voxels.
struct SurfaceVertex {
    Eigen::Vector3f p_W = Eigen::Vector3f::Zero();       ///< (m)
    Eigen::Vector3f normal_W = Eigen::Vector3f::Zero();  ///< unit, into free space
    float sigma_m = 0.0F;                                ///< along the normal, if the views erred apart
    float grey = 0.0F;                                   ///< mean of the images
    std::uint16_t last = 0;                              ///< number of the newest view that measured it
    std::array<std::int8_t, 3> cell{};                   ///< its cell's least corner, in voxels of the block: -1 to 7
};

struct SurfaceTriangle {
    std::array<std::uint16_t, 3> vertex{};  ///< counterclockwise as seen from free space
    std::uint16_t views = 0;                ///< that measured it
    float sigma_m = 0.0F;                   ///< as a vertex's
};

/// The surface that belongs to one block. Vertices at its border are those of its neighbours, too: blocks that have
/// been extracted from the same voxels have them at the same places. About 80 KB.
struct SurfacePiece {
    static constexpr int kCells = TsdfVolume::kSide + 1;  ///< along each axis, those before the block included

    Eigen::Vector3i at = Eigen::Vector3i::Zero();        ///< the block
    Eigen::Vector3f corner_W = Eigen::Vector3f::Zero();  ///< its corner of least coordinates (m)
    FixedVector<SurfaceVertex, kCells * kCells * kCells> vertices;
    FixedVector<SurfaceTriangle, 6 * TsdfVolume::kVoxels> triangles;
};

/// What counts as surface.
struct SurfaceOptions {
    double max_sigma_m = 0.03;  ///< of the mean over the views
    int min_views = 1;
    /// Views that saw through it, for each one that measured it. Wrong depths are mostly those of a foreground, alike
    /// in all views from one side; depths behind the true surface are rare. So few views through outweigh many.
    double max_through = 0.1;
};

/// Surface nets [Gibson98]: a vertex in every cell of eight voxels that the surface passes, at the mean of where it
/// crosses the cell's edges, and two triangles across every edge that it crosses. Where the distance jumps from one
/// voxel to the next by more than they are apart, two surfaces meet in sight but not in space: that is no crossing.
/// About 20 KB. No heap. Thread-bound. Deterministic.
class SurfaceNets {
public:
    explicit SurfaceNets(const SurfaceOptions& options = {}) : options_(options) {}

    /// @param slot  of a used block
    void extract(const TsdfVolume& volume, std::size_t slot, SurfacePiece& piece);

private:
    static constexpr int kReach = TsdfVolume::kSide + 2;  ///< voxels along each axis: one more on either side

    /// A voxel that counts.
    struct Point {
        float distance = 0.0F;
        const Voxel* voxel = nullptr;  ///< null: it does not
    };

    void load(const TsdfVolume& volume, const TsdfVolume::Block& block);
    const Point& point(const Eigen::Vector3i& v) const {
        return points_[static_cast<std::size_t>(((v.z() + 1) * kReach + v.y() + 1) * kReach + v.x() + 1)];
    }
    bool crosses(const Point& a, const Point& b) const {
        return a.voxel != nullptr && b.voxel != nullptr && (a.distance > 0.0F) != (b.distance > 0.0F) &&
               std::abs(a.distance - b.distance) <= most_change_;
    }
    void place_faces(const Eigen::Vector3i& v, SurfacePiece& piece);
    int vertex_at(const Eigen::Vector3i& cell, SurfacePiece& piece);
    SurfaceVertex place_vertex(const Eigen::Vector3i& cell, const Eigen::Vector3i& block) const;

    SurfaceOptions options_;
    float voxel_ = 0.0F;
    float most_change_ = 0.0F;
    std::array<Point, kReach * kReach * kReach> points_{};
    std::array<int, SurfacePiece::kCells * SurfacePiece::kCells * SurfacePiece::kCells> vertex_of_{};
};

}  // namespace facet
