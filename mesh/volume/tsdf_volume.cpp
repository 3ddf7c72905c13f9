// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/tsdf_volume.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "platform/base/hash64.h"

namespace facet {
namespace {

constexpr float kNearest = 0.1F;       // m
constexpr float kLeastSigma = 0.003F;  // m: that of a calibration, common to all views
constexpr float kPassed = 3.0F;        // sigmas that a voxel must lie before a surface to have been seen through
constexpr int kCoordinate = 1 << 20;   // blocks to either side of the origin

std::uint64_t key_of(const Eigen::Vector3i& at) {
    const Eigen::Matrix<std::uint64_t, 3, 1> shifted = (at.array() + kCoordinate).matrix().cast<std::uint64_t>();
    return (shifted.x() << 42U) | (shifted.y() << 21U) | shifted.z();
}

std::uint16_t more(std::uint16_t count) {
    return count < std::numeric_limits<std::uint16_t>::max() ? static_cast<std::uint16_t>(count + 1) : count;
}

}  // namespace

TsdfVolume::TsdfVolume(const TsdfOptions& options)
    : options_(options),
      blocks_(options.max_blocks),
      index_(std::bit_ceil(2 * options.max_blocks + 1), -1),
      by_distance_(options.max_blocks) {
    free_.reserve(options.max_blocks);
}

void TsdfVolume::clear() {
    for (std::size_t slot = 0; slot < slot_end_; ++slot) {
        blocks_[slot].is_used = false;
    }
    std::ranges::fill(index_, -1);
    free_.clear();
    slot_end_ = used_ = 0;
    view_ = {};
    next_patch_ = next_slot_ = 0;
}

/// Where a block's search begins.
std::size_t TsdfVolume::bucket_of(const Eigen::Vector3i& at) const {
    return static_cast<std::size_t>(mix64(key_of(at))) & (index_.size() - 1);
}

int TsdfVolume::find(const Eigen::Vector3i& at) const {
    for (std::size_t i = bucket_of(at); index_[i] >= 0; i = (i + 1) & (index_.size() - 1)) {
        if (blocks_[static_cast<std::size_t>(index_[i])].at == at) {
            return index_[i];
        }
    }
    return -1;
}

void TsdfVolume::add(const Eigen::Vector3d& p_W) {
    const Eigen::Vector3d place = p_W / (kSide * options_.voxel_m);
    if (!(place.cwiseAbs().maxCoeff() < kCoordinate - 1)) {  // also what is no number
        return;
    }
    const Eigen::Vector3i at = place.array().floor().matrix().cast<int>();
    std::size_t i = bucket_of(at);
    for (; index_[i] >= 0; i = (i + 1) & (index_.size() - 1)) {
        if (blocks_[static_cast<std::size_t>(index_[i])].at == at) {
            return;
        }
    }
    if (used_ >= blocks_.size()) {
        ++refused_;
        return;
    }
    std::size_t slot = slot_end_;
    if (free_.empty()) {
        ++slot_end_;
    } else {
        slot = static_cast<std::size_t>(free_.back());
        free_.pop_back();
    }
    index_[i] = static_cast<int>(slot);
    ++used_;
    Block& block = blocks_[slot];
    block.at = at;
    block.is_used = true;
    block.is_stale = false;
    block.voxels.fill({});
}

/// Those behind it in its run of places move up, as far as their own search allows.
void TsdfVolume::remove(std::size_t slot) {
    const std::size_t mask = index_.size() - 1;
    std::size_t hole = bucket_of(blocks_[slot].at);
    while (index_[hole] != static_cast<int>(slot)) {
        hole = (hole + 1) & mask;
    }
    for (std::size_t i = (hole + 1) & mask; index_[i] >= 0; i = (i + 1) & mask) {
        const std::size_t home = bucket_of(blocks_[static_cast<std::size_t>(index_[i])].at);
        if (((i - home) & mask) >= ((i - hole) & mask)) {
            index_[hole] = index_[i];
            hole = i;
        }
    }
    index_[hole] = -1;
    blocks_[slot].is_used = false;
    free_.push_back(static_cast<int>(slot));
    --used_;
    ++left_;
}

void TsdfVolume::make_room(const Eigen::Vector3d& p_W, std::size_t wanted) {
    wanted = std::min(wanted, blocks_.size());
    const std::size_t room = blocks_.size() - used_;
    if (room >= wanted) {
        return;
    }
    const Eigen::Vector3d here = p_W / (kSide * options_.voxel_m) - Eigen::Vector3d::Constant(0.5);
    const auto distance = [&](int slot) {
        return (blocks_[static_cast<std::size_t>(slot)].at.cast<double>() - here).squaredNorm();
    };
    auto* end = by_distance_.data();
    for (std::size_t slot = 0; slot < slot_end_; ++slot) {
        if (blocks_[slot].is_used) {
            *end++ = static_cast<int>(slot);
        }
    }
    auto* const last = by_distance_.data() + (wanted - room);
    std::nth_element(by_distance_.data(), last, end, [&](int a, int b) {
        const double far_a = distance(a);
        const double far_b = distance(b);
        return far_a != far_b ? far_a > far_b : a < b;
    });
    for (const int* slot = by_distance_.data(); slot != last; ++slot) {
        remove(static_cast<std::size_t>(*slot));
    }
}

void TsdfVolume::begin(const SquareRaster& raster, const std::vector<SurfacePatch>& patches, const Se3& T_W_C,
                       std::uint16_t number) {
    view_ = {&raster, &patches, T_W_C, T_W_C.q.conjugate().toRotationMatrix().cast<float>(), number};
    next_patch_ = next_slot_ = 0;
}

bool TsdfVolume::add_blocks(int count) {
    const std::vector<SurfacePatch>& patches = *view_.patches;
    const std::size_t end = std::min(patches.size(), next_patch_ + static_cast<std::size_t>(count));
    for (; next_patch_ < end; ++next_patch_) {
        const SurfacePatch& patch = patches[next_patch_];
        if (!patch.exists()) {
            continue;
        }
        const Eigen::Vector3d n = patch.n_C.cast<double>();
        const Eigen::Vector3d ray = view_.raster->middle(next_patch_).cast<double>().homogeneous();
        const double rho = n.dot(ray);
        if (!(rho * options_.max_depth_m > 1.0) ||
            static_cast<double>(patch.sigma) / (rho * n.norm()) > options_.max_sigma_m) {
            continue;
        }
        const Eigen::Vector3d p = view_.T_W_C * (ray / rho);
        const Eigen::Vector3d normal = view_.T_W_C.q * n.normalized();
        for (const double step : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
            add(p + step * options_.band_m * normal);
        }
    }
    return next_patch_ < patches.size();
}

bool TsdfVolume::update_blocks(int count) {
    constexpr int kOutOfView = 32;  // blocks that cost as much as one in view
    for (int cost = 0; next_slot_ < slot_end_ && cost < count * kOutOfView; ++next_slot_) {
        Block& block = blocks_[next_slot_];
        ++cost;
        if (block.is_used) {
            cost += update(block) ? kOutOfView : 0;
        }
    }
    return next_slot_ < slot_end_;
}

void TsdfVolume::integrate(const SquareRaster& raster, const std::vector<SurfacePatch>& patches, const Se3& T_W_C) {
    begin(raster, patches, T_W_C, static_cast<std::uint16_t>(view_.number + 1));
    while (add_blocks(1 << 10)) {
    }
    while (update_blocks(1 << 10)) {
    }
}

/// @return whether it may be in view
bool TsdfVolume::update(Block& block) {
    const double voxel = options_.voxel_m;
    const Eigen::Vector3d corner = voxel * kSide * block.at.cast<double>();
    const Eigen::Vector3f first = view_.R_C_W * (corner - view_.T_W_C.p).cast<float>();
    const Eigen::Matrix3f axes = view_.R_C_W * static_cast<float>(voxel);
    const Eigen::Vector3f centre = first + axes * Eigen::Vector3f::Constant(0.5F * kSide);
    const float radius = 0.5F * std::sqrt(3.0F) * kSide * static_cast<float>(voxel);
    if (!(centre.z() >= -radius) || !view_.raster->may_show(centre, radius)) {
        return false;
    }
    std::size_t i = 0;
    bool is_changed = false;
    for (int z = 0; z < kSide; ++z) {
        for (int y = 0; y < kSide; ++y) {
            const Eigen::Vector3f row =
                first + axes.col(1) * static_cast<float>(y) + axes.col(2) * static_cast<float>(z);
            for (int x = 0; x < kSide; ++x, ++i) {
                is_changed |= update(block.voxels[i], row + axes.col(0) * static_cast<float>(x));
            }
        }
    }
    if (is_changed) {
        mark_stale(block);
    }
    return true;
}

/// A surface's cells reach one voxel into the blocks around.
void TsdfVolume::mark_stale(const Block& block) {
    for (int i = 0; i < 27; ++i) {
        const int slot = find(block.at + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
        if (slot >= 0) {
            blocks_[static_cast<std::size_t>(slot)].is_stale = true;
        }
    }
}

/// @return whether it has changed
bool TsdfVolume::update(Voxel& voxel, const Eigen::Vector3f& p_C) const {
    if (!(p_C.z() >= kNearest)) {
        return false;
    }
    const int square = view_.raster->square_at(p_C.x() / p_C.z(), p_C.y() / p_C.z());
    if (square < 0 || !(*view_.patches)[static_cast<std::size_t>(square)].exists()) {
        return false;
    }
    const SurfacePatch& patch = (*view_.patches)[static_cast<std::size_t>(square)];
    const auto band = static_cast<float>(options_.band_m);
    const float scale = 1.0F / patch.n_C.norm();
    const float distance = (1.0F - patch.n_C.dot(p_C)) * scale;
    // 1 - n . p grows by Z d(1/Z): the plane's doubt along its normal, at this voxel.
    const float sigma = p_C.z() * patch.sigma * scale;
    if (!(distance >= -band)) {
        return false;
    }
    if (distance > std::max(band, kPassed * sigma)) {
        const bool sees_through = !patch.is_inferred && voxel.views > 0;
        voxel.through = patch.is_inferred ? voxel.through : more(voxel.through);
        return sees_through;
    }
    if (distance > band || p_C.z() > static_cast<float>(options_.max_depth_m) ||
        !(sigma <= static_cast<float>(options_.max_sigma_m))) {
        return false;
    }
    const float fade = std::min(1.0F, 1.0F + distance / band);
    const float weight = fade / (sigma * sigma + kLeastSigma * kLeastSigma);
    if (!(weight > 0.0F)) {  // at the band's very end
        return false;
    }
    voxel.weight += weight;
    const float share = weight / voxel.weight;
    voxel.distance += (distance - voxel.distance) * share;
    const auto grey = static_cast<float>(voxel.grey);
    voxel.grey = static_cast<std::uint16_t>(std::lround(grey + (256.0F * patch.grey - grey) * share));
    voxel.views = more(voxel.views);
    voxel.last = view_.number;
    return true;
}

}  // namespace facet
