// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/surface_nets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr int kSide = TsdfVolume::kSide;
constexpr float kMostChange = 1.5F;  // voxels that the distance may change from one to the next

template <typename Visit>
void for_voxels(int from, int to, const Visit& visit) {
    for (int z = from; z < to; ++z) {
        for (int y = from; y < to; ++y) {
            for (int x = from; x < to; ++x) {
                visit(Eigen::Vector3i(x, y, z));
            }
        }
    }
}

}  // namespace

void SurfaceNets::extract(const TsdfVolume& volume, std::size_t slot, SurfacePiece& piece) {
    const TsdfVolume::Block& block = volume.block(slot);
    voxel_ = static_cast<float>(volume.options().voxel_m);
    piece.at = block.at;
    piece.corner_W = static_cast<float>(kSide) * voxel_ * block.at.cast<float>();
    piece.vertices.clear();
    piece.triangles.clear();
    most_change_ = kMostChange * voxel_;
    vertex_of_.fill(-1);
    load(volume, block);
    for_voxels(0, kSide, [&](const Eigen::Vector3i& v) { place_faces(v, piece); });
}

void SurfaceNets::load(const TsdfVolume& volume, const TsdfVolume::Block& block) {
    std::array<const TsdfVolume::Block*, 27> near{};
    for (int i = 0; i < 27; ++i) {
        const int slot = volume.find(block.at + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
        near[static_cast<std::size_t>(i)] = slot < 0 ? nullptr : &volume.block(static_cast<std::size_t>(slot));
    }
    const auto least_weight = static_cast<float>(1.0 / (options_.max_sigma_m * options_.max_sigma_m));
    auto* point = points_.data();
    for_voxels(-1, kSide + 1, [&](const Eigen::Vector3i& v) {
        const Eigen::Vector3i o = (v.array() + kSide).matrix() / kSide;
        const TsdfVolume::Block* const from = near[static_cast<std::size_t>((o.z() * 3 + o.y()) * 3 + o.x())];
        *point = {};
        if (from != nullptr) {
            const Voxel& voxel =
                from->voxels[TsdfVolume::index_of(v.x() & (kSide - 1), v.y() & (kSide - 1), v.z() & (kSide - 1))];
            if (voxel.weight >= least_weight && voxel.views >= options_.min_views &&
                voxel.through <= options_.max_through * voxel.views) {
                *point = {voxel.distance, &voxel};
            }
        }
        ++point;
    });
}

/// Across the edges from v along each axis.
void SurfaceNets::place_faces(const Eigen::Vector3i& v, SurfacePiece& piece) {
    const Point& at = point(v);
    if (at.voxel == nullptr) {
        return;
    }
    for (int axis = 0; axis < 3; ++axis) {
        const Point& next = point(v + Eigen::Vector3i::Unit(axis));
        if (!crosses(at, next)) {
            continue;
        }
        const Eigen::Vector3i x = Eigen::Vector3i::Unit((axis + 1) % 3);
        const Eigen::Vector3i y = Eigen::Vector3i::Unit((axis + 2) % 3);
        std::array<int, 4> q{vertex_at(v - x - y, piece), vertex_at(v - y, piece), vertex_at(v, piece),
                             vertex_at(v - x, piece)};
        if (at.distance > 0.0F) {  // else free space is along the axis, about which the ring runs
            std::ranges::reverse(q);
        }
        const auto p = [&](std::size_t k) { return piece.vertices[static_cast<std::size_t>(q[k])].p_W; };
        const bool is_first_shorter = (p(2) - p(0)).squaredNorm() <= (p(3) - p(1)).squaredNorm();
        const std::size_t first = is_first_shorter ? 0 : 1;
        const auto views = std::min(at.voxel->views, next.voxel->views);
        const float sigma = 1.0F / std::sqrt(std::min(at.voxel->weight, next.voxel->weight));
        const auto corner = [&](std::size_t k) { return static_cast<std::uint16_t>(q[(first + k) % 4]); };
        piece.triangles.push_back({{corner(0), corner(1), corner(2)}, views, sigma});
        piece.triangles.push_back({{corner(0), corner(2), corner(3)}, views, sigma});
    }
}

/// That of a cell which the surface passes: made when it is asked for first.
int SurfaceNets::vertex_at(const Eigen::Vector3i& cell, SurfacePiece& piece) {
    constexpr int kCells = SurfacePiece::kCells;
    int& index = vertex_of_[static_cast<std::size_t>(((cell.z() + 1) * kCells + cell.y() + 1) * kCells + cell.x() + 1)];
    if (index < 0) {
        index = static_cast<int>(piece.vertices.size());
        piece.vertices.push_back(place_vertex(cell, piece.at));
    }
    return index;
}

SurfaceVertex SurfaceNets::place_vertex(const Eigen::Vector3i& cell, const Eigen::Vector3i& block) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    Eigen::Vector3f slope = Eigen::Vector3f::Zero();  // along each axis, summed
    Eigen::Vector3f edges = Eigen::Vector3f::Zero();  // over so many
    float weight = 0.0F;
    float grey = 0.0F;
    int count = 0;
    SurfaceVertex vertex;
    for (unsigned i = 0; i < 8; ++i) {
        const Eigen::Vector3i v(static_cast<int>(i & 1U), static_cast<int>(i >> 1U & 1U), static_cast<int>(i >> 2U));
        const Point& a = point(cell + v);
        for (int axis = 0; axis < 3; ++axis) {
            const Point& b = point(cell + v + (v[axis] == 0 ? 1 : 0) * Eigen::Vector3i::Unit(axis));
            if (v[axis] != 0 || a.voxel == nullptr || b.voxel == nullptr ||
                std::abs(a.distance - b.distance) > most_change_) {
                continue;
            }
            slope[axis] += b.distance - a.distance;
            edges[axis] += 1.0F;
            if (!crosses(a, b)) {
                continue;
            }
            Eigen::Vector3f p = v.cast<float>();
            p[axis] = a.distance / (a.distance - b.distance);
            sum += p;
            ++count;
            weight += 0.5F * (a.voxel->weight + b.voxel->weight);
            const Voxel& nearer = std::abs(a.distance) < std::abs(b.distance) ? *a.voxel : *b.voxel;
            grey += static_cast<float>(nearer.grey);
            vertex.last = nearer.last;
        }
    }
    const auto n = static_cast<float>(count);
    const Eigen::Vector3i at = kSide * block + cell;
    vertex.p_W = voxel_ * (at.cast<float>() + sum / n);
    slope = (slope.array() / edges.array().max(1.0F)).matrix();
    vertex.normal_W = slope.norm() > 0.0F ? slope.normalized() : Eigen::Vector3f(0.0F, 0.0F, 1.0F);
    vertex.sigma_m = 1.0F / std::sqrt(weight / n);
    vertex.grey = grey / (256.0F * n);
    for (int axis = 0; axis < 3; ++axis) {
        vertex.cell[static_cast<std::size_t>(axis)] = static_cast<std::int8_t>(cell[axis]);
    }
    return vertex;
}

}  // namespace facet
