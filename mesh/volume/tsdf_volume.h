// SPDX-License-Identifier: BSD-2-Clause
// Signed distances to the surfaces that many views have measured, in blocks where there are surfaces.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
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
    std::uint16_t grey = 0;     ///< of that surface in the images, weighted likewise (1/256 grey)
    std::uint16_t last = 0;     ///< number of the newest of `views`
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
/// falling to nothing, so that thin things keep both of their sides. A view may be integrated in parts, which together
/// do the same: begin(), add_blocks() until it is false, update_blocks() until it is false. Heap in the constructor
/// only: all blocks at once. Thread-bound. Deterministic.
class TsdfVolume {
public:
    static constexpr int kSide = 8;  ///< voxels of a block along each axis
    static constexpr int kVoxels = kSide * kSide * kSide;
    struct Block {
        Eigen::Vector3i at = Eigen::Vector3i::Zero();  ///< in blocks
        bool is_used = false;
        bool is_stale = false;  ///< voxels in it or beside it have changed since clear_stale()
        std::array<Voxel, kVoxels> voxels{};
    };

    explicit TsdfVolume(const TsdfOptions& options);

    /// Forgets everything.
    void clear();

    /// A view begins; one that was not finished is left as it is. @param number  its number, for Voxel::last
    /// @param patches  of each square of the raster's image, which T_W_C has taken; both outlast the integration
    void begin(const SquareRaster& raster, const std::vector<SurfacePatch>& patches, const Se3& T_W_C,
               std::uint16_t number);
    /// Blocks about the next patches. @return whether there are more patches
    bool add_blocks(int patches);
    /// Voxels of the next blocks; blocks out of view cost hardly anything. @return whether there are more
    bool update_blocks(int blocks);
    /// All of it.
    void integrate(const SquareRaster& raster, const std::vector<SurfacePatch>& patches, const Se3& T_W_C);

    /// Gives up the blocks that are farthest from a place until there is room for `wanted`.
    void make_room(const Eigen::Vector3d& p_W, std::size_t wanted);

    const TsdfOptions& options() const { return options_; }
    std::size_t block_count() const { return used_; }
    /// Blocks are at slots below this; not all of these are used.
    std::size_t slot_end() const { return slot_end_; }
    const Block& block(std::size_t slot) const { return blocks_[slot]; }
    /// Slot of the block, or -1.
    int find(const Eigen::Vector3i& at) const;
    void clear_stale(std::size_t slot) { blocks_[slot].is_stale = false; }
    std::size_t refused() const { return refused_; }  ///< blocks for which there was no room,
    std::size_t left() const { return left_; }        ///< and that were given up

    static std::size_t index_of(int x, int y, int z) { return static_cast<std::size_t>((z * kSide + y) * kSide + x); }

private:
    struct View {
        const SquareRaster* raster = nullptr;
        const std::vector<SurfacePatch>* patches = nullptr;
        Se3 T_W_C;
        Eigen::Matrix3f R_C_W = Eigen::Matrix3f::Identity();
        std::uint16_t number = 0;
    };
    std::size_t bucket_of(const Eigen::Vector3i& at) const;
    void add(const Eigen::Vector3d& p_W);
    void remove(std::size_t slot);
    bool update(Block& block);
    bool update(Voxel& voxel, const Eigen::Vector3f& p_C) const;
    void mark_stale(const Block& block);

    TsdfOptions options_;
    std::vector<Block> blocks_;  ///< of max_blocks
    std::vector<int> index_;     ///< slots by hash, or -1: open addressing, each run of places without a gap
    std::vector<int> free_;      ///< slots below slot_end_ that are not used, the last one next
    std::vector<int> by_distance_;
    std::size_t slot_end_ = 0;
    std::size_t used_ = 0;
    std::size_t refused_ = 0;
    std::size_t left_ = 0;
    View view_;
    std::size_t next_patch_ = 0;
    std::size_t next_slot_ = 0;
};

}  // namespace facet
