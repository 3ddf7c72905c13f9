// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/tsdf_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

struct TsdfVolume::View {
    const SquareRaster& raster;
    const std::vector<SurfacePatch>& patches;
    Eigen::Matrix3f R_C_W;
    Eigen::Vector3d p_W_C;
};

int TsdfVolume::find(const Eigen::Vector3i& at) const {
    const auto found = index_.find(key_of(at));
    return found == index_.end() ? -1 : found->second;
}

void TsdfVolume::add(const Eigen::Vector3d& p_W) {
    const Eigen::Vector3i at = (p_W / (kSide * options_.voxel_m)).array().floor().matrix().cast<int>();
    if (at.cwiseAbs().maxCoeff() >= kCoordinate) {
        return;
    }
    const std::uint64_t key = key_of(at);
    if (index_.contains(key)) {
        return;
    }
    if (blocks_.size() >= options_.max_blocks) {
        ++refused_;
        return;
    }
    index_.emplace(key, static_cast<int>(blocks_.size()));
    blocks_.emplace_back().at = at;
}

void TsdfVolume::integrate(const SquareRaster& raster, const std::vector<SurfacePatch>& patches, const Se3& T_W_C) {
    for (std::size_t i = 0; i < patches.size(); ++i) {
        const SurfacePatch& patch = patches[i];
        if (!patch.exists()) {
            continue;
        }
        const Eigen::Vector3d n = patch.n_C.cast<double>();
        const Eigen::Vector3d ray = raster.middle(i).cast<double>().homogeneous();
        const double rho = n.dot(ray);
        if (rho * options_.max_depth_m <= 1.0 ||
            static_cast<double>(patch.sigma) / (rho * n.norm()) > options_.max_sigma_m) {
            continue;
        }
        const Eigen::Vector3d p = T_W_C * (ray / rho);
        const Eigen::Vector3d normal = T_W_C.q * n.normalized();
        for (const double step : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
            add(p + step * options_.band_m * normal);
        }
    }
    const Eigen::Quaterniond q_C_W = T_W_C.q.conjugate();
    const View view{raster, patches, q_C_W.toRotationMatrix().cast<float>(), T_W_C.p};
    for (Block& block : blocks_) {
        update(block, view);
    }
}

void TsdfVolume::update(Block& block, const View& view) const {
    const double voxel = options_.voxel_m;
    const Eigen::Vector3d corner = voxel * kSide * block.at.cast<double>();
    const Eigen::Vector3f first = view.R_C_W * (corner - view.p_W_C).cast<float>();
    const Eigen::Matrix3f axes = view.R_C_W * static_cast<float>(voxel);
    const Eigen::Vector3f centre = first + axes * Eigen::Vector3f::Constant(0.5F * kSide);
    const float radius = 0.5F * std::sqrt(3.0F) * kSide * static_cast<float>(voxel);
    if (centre.z() < -radius || !view.raster.may_show(centre, radius)) {
        return;
    }
    std::size_t i = 0;
    for (int z = 0; z < kSide; ++z) {
        for (int y = 0; y < kSide; ++y) {
            const Eigen::Vector3f row =
                first + axes.col(1) * static_cast<float>(y) + axes.col(2) * static_cast<float>(z);
            for (int x = 0; x < kSide; ++x, ++i) {
                update(block.voxels[i], row + axes.col(0) * static_cast<float>(x), view);
            }
        }
    }
}

void TsdfVolume::update(Voxel& voxel, const Eigen::Vector3f& p_C, const View& view) const {
    if (p_C.z() < kNearest) {
        return;
    }
    const int square = view.raster.square_at(p_C.x() / p_C.z(), p_C.y() / p_C.z());
    if (square < 0 || !view.patches[static_cast<std::size_t>(square)].exists()) {
        return;
    }
    const SurfacePatch& patch = view.patches[static_cast<std::size_t>(square)];
    const auto band = static_cast<float>(options_.band_m);
    const float scale = 1.0F / patch.n_C.norm();
    const float distance = (1.0F - patch.n_C.dot(p_C)) * scale;
    // 1 - n . p grows by Z d(1/Z): the plane's doubt along its normal, at this voxel.
    const float sigma = p_C.z() * patch.sigma * scale;
    if (distance < -band) {
        return;
    }
    if (distance > std::max(band, kPassed * sigma)) {
        if (!patch.is_inferred) {
            voxel.through = more(voxel.through);
        }
        return;
    }
    if (distance > band || p_C.z() > static_cast<float>(options_.max_depth_m) ||
        sigma > static_cast<float>(options_.max_sigma_m)) {
        return;
    }
    const float fade = std::min(1.0F, 1.0F + distance / band);
    const float weight = fade / (sigma * sigma + kLeastSigma * kLeastSigma);
    voxel.weight += weight;
    voxel.distance += (distance - voxel.distance) * weight / voxel.weight;
    voxel.views = more(voxel.views);
}

}  // namespace facet
