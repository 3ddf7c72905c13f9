// SPDX-License-Identifier: BSD-2-Clause
// Signed distances to the surfaces that many views have measured, in blocks where there are surfaces.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "estimator/geometry/se3.h"
#include "mesh/volume/surface_patches.h"

namespace facet {

/// What is known at one point of the volume's lattice.
struct Voxel {
    float distance = 0.0F;      ///< to the surface, weighted mean over the views, > 0 in front of it (m)
    float weight = 0.0F;        ///< sum of inverse variances (1/m^2); 0: nothing is known
    std::uint16_t views = 0;    ///< that measured or inferred a surface within the band about it
    std::uint16_t through = 0;  ///< that measured something well behind it
};

struct TsdfOptions {
    double voxel_m = 0.04;
    double band_m = 0.12;            ///< distances are kept up to here, on both sides of a surface
    double max_sigma_m = 0.08;       ///< along the normal: what a view measures worse than this does not count
    double max_depth_m = 100.0;      ///< farther away a view measures nothing, but sees through what is nearer
    std::size_t max_blocks = 32768;  ///< 32 cm wide and of 8 KB; when there are as many, no more are added
};

/// Truncated signed distance field [Curless96] over a hash of blocks [Niessner13]. A view gives every voxel within the
/// band about a patch its distance from that patch's plane, weighted by the plane's variance, and behind the surface
/// falling to nothing, so that thin things keep both of their sides. Heap. Thread-bound. Deterministic.
class TsdfVolume {
public:
    static constexpr int kSide = 8;  ///< voxels of a block along each axis
    static constexpr int kVoxels = kSide * kSide * kSide;
    struct Block {
        Eigen::Vector3i at;  ///< in blocks
        std::array<Voxel, kVoxels> voxels{};
    };

    explicit TsdfVolume(const TsdfOptions& options) : options_(options) {}

    /// @param patches  of each square of the raster's image, which T_W_C has taken
    void integrate(const SquareRaster& raster, const std::vector<SurfacePatch>& patches, const Se3& T_W_C);

    const TsdfOptions& options() const { return options_; }
    std::size_t block_count() const { return blocks_.size(); }
    /// In the order in which they were added.
    const Block& block(std::size_t index) const { return blocks_[index]; }
    /// Index of the block, or -1.
    int find(const Eigen::Vector3i& at) const;
    std::size_t refused() const { return refused_; }  ///< blocks for which there was no room

    static std::size_t index_of(int x, int y, int z) { return static_cast<std::size_t>((z * kSide + y) * kSide + x); }

private:
    struct View;
    void add(const Eigen::Vector3d& p_W);
    void update(Block& block, const View& view) const;
    void update(Voxel& voxel, const Eigen::Vector3f& p_C, const View& view) const;

    TsdfOptions options_;
    std::vector<Block> blocks_;
    std::unordered_map<std::uint64_t, int> index_;
    std::size_t refused_ = 0;
};

}  // namespace facet
