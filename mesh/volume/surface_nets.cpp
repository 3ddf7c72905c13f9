// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/surface_nets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace facet {
namespace {

constexpr int kSide = TsdfVolume::kSide;
constexpr float kMostChange = 1.5F;  // voxels that the distance may change from one to the next

class SurfaceNets {
public:
    SurfaceNets(const TsdfVolume& volume, const SurfaceOptions& options)
        : volume_(volume),
          options_(options),
          voxel_(static_cast<float>(volume.options().voxel_m)),
          least_weight_(static_cast<float>(1.0 / (options.max_sigma_m * options.max_sigma_m))) {}

    FusedMesh run() {
        vertex_of_.resize(volume_.block_count());
        for (std::size_t b = 0; b < volume_.block_count(); ++b) {
            vertex_of_[b].fill(-1);
            find_neighbours(b);
            for_voxels([&](const Eigen::Vector3i& v) { place_vertex(b, v); });
        }
        for (std::size_t b = 0; b < volume_.block_count(); ++b) {
            find_neighbours(b);
            for_voxels([&](const Eigen::Vector3i& v) { place_faces(v); });
        }
        return std::move(mesh_);
    }

private:
    template <typename Visit>
    static void for_voxels(const Visit& visit) {
        for (int z = 0; z < kSide; ++z) {
            for (int y = 0; y < kSide; ++y) {
                for (int x = 0; x < kSide; ++x) {
                    visit({x, y, z});
                }
            }
        }
    }

    /// The 27 blocks about one.
    void find_neighbours(std::size_t b) {
        for (int i = 0; i < 27; ++i) {
            const Eigen::Vector3i offset(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
            near_[static_cast<std::size_t>(i)] = volume_.find(volume_.block(b).at + offset);
        }
    }
    /// @param v  in voxels of the block in the middle; at most a block beside it
    int block_at(const Eigen::Vector3i& v) const {
        const Eigen::Vector3i o = (v.array() + kSide).matrix() / kSide;
        return near_[static_cast<std::size_t>((o.z() * 3 + o.y()) * 3 + o.x())];
    }
    static std::size_t index_in(const Eigen::Vector3i& v) {
        return TsdfVolume::index_of(v.x() & (kSide - 1), v.y() & (kSide - 1), v.z() & (kSide - 1));
    }
    const Voxel* voxel_at(const Eigen::Vector3i& v) const {
        const int b = block_at(v);
        if (b < 0) {
            return nullptr;
        }
        const Voxel& voxel = volume_.block(static_cast<std::size_t>(b)).voxels[index_in(v)];
        const bool counts = voxel.weight >= least_weight_ && voxel.views >= options_.min_views &&
                            voxel.through <= options_.max_through * voxel.views;
        return counts ? &voxel : nullptr;
    }

    bool crosses(const Voxel* a, const Voxel* b) const {
        return a != nullptr && b != nullptr && (a->distance > 0.0F) != (b->distance > 0.0F) &&
               std::abs(a->distance - b->distance) <= kMostChange * voxel_;
    }

    /// The cell whose least corner is v.
    void place_vertex(std::size_t b, const Eigen::Vector3i& v) {
        std::array<const Voxel*, 8> corner{};
        for (int i = 0; i < 8; ++i) {
            corner[static_cast<std::size_t>(i)] = voxel_at(v + Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2));
        }
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        int count = 0;
        for (unsigned i = 0; i < 8; ++i) {
            for (unsigned axis = 0; axis < 3; ++axis) {
                const unsigned j = i | 1U << axis;
                if (j == i || !crosses(corner[i], corner[j])) {
                    continue;
                }
                Eigen::Vector3f p(static_cast<float>(i & 1U), static_cast<float>(i >> 1U & 1U),
                                  static_cast<float>(i >> 2U));
                p[axis] = corner[i]->distance / (corner[i]->distance - corner[j]->distance);
                sum += p;
                ++count;
            }
        }
        if (count > 0) {
            vertex_of_[b][index_in(v)] = static_cast<int>(mesh_.vertices.size());
            const Eigen::Vector3i at = kSide * volume_.block(b).at + v;
            mesh_.vertices.push_back(voxel_ * (at.cast<float>() + sum / static_cast<float>(count)));
            mesh_.normals.push_back(Eigen::Vector3f::Zero());
        }
    }

    /// Across the edges from v along each axis.
    void place_faces(const Eigen::Vector3i& v) {
        const Voxel* const at = voxel_at(v);
        if (at == nullptr) {
            return;
        }
        for (int axis = 0; axis < 3; ++axis) {
            const Voxel* const next = voxel_at(v + Eigen::Vector3i::Unit(axis));
            if (!crosses(at, next)) {
                continue;
            }
            const Eigen::Vector3i x = Eigen::Vector3i::Unit((axis + 1) % 3);
            const Eigen::Vector3i y = Eigen::Vector3i::Unit((axis + 2) % 3);
            std::array<int, 4> ring{vertex_at(v - x - y), vertex_at(v - y), vertex_at(v), vertex_at(v - x)};
            if (std::ranges::find(ring, -1) != ring.end()) {
                continue;
            }
            if (at->distance > 0.0F) {  // else free space is along the axis, about which the ring runs
                std::ranges::reverse(ring);
            }
            add_quad(ring, std::min(at->weight, next->weight), std::min(at->views, next->views));
        }
    }

    /// -1 where the cell's least corner is in no block.
    int vertex_at(const Eigen::Vector3i& v) const {
        const int b = block_at(v);
        return b < 0 ? -1 : vertex_of_[static_cast<std::size_t>(b)][index_in(v)];
    }

    void add_quad(const std::array<int, 4>& q, float weight, int views) {
        const auto p = [&](int k) -> const Eigen::Vector3f& {
            return mesh_.vertices[static_cast<std::size_t>(q[static_cast<std::size_t>(k)])];
        };
        const bool is_first_shorter = (p(2) - p(0)).squaredNorm() <= (p(3) - p(1)).squaredNorm();
        const std::array<Eigen::Vector3i, 2> halves =
            is_first_shorter ? std::array{Eigen::Vector3i(q[0], q[1], q[2]), Eigen::Vector3i(q[0], q[2], q[3])}
                             : std::array{Eigen::Vector3i(q[1], q[2], q[3]), Eigen::Vector3i(q[1], q[3], q[0])};
        for (const Eigen::Vector3i& t : halves) {
            mesh_.triangles.push_back(t);
            mesh_.observations.push_back(views);
            mesh_.sigmas.push_back(1.0F / std::sqrt(weight));
        }
    }

    const TsdfVolume& volume_;
    const SurfaceOptions& options_;
    float voxel_;
    float least_weight_;
    std::array<int, 27> near_{};
    std::vector<std::array<int, TsdfVolume::kVoxels>> vertex_of_;
    FusedMesh mesh_;
};

Eigen::Vector3f area_vector(const FusedMesh& mesh, const Eigen::Vector3i& t) {
    const auto p = [&](int k) -> const Eigen::Vector3f& { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    return 0.5F * (p(1) - p(0)).cross(p(2) - p(0));
}

/// Leaves out pieces smaller than `least_m2`, and vertices without triangles.
FusedMesh without_crumbs(const FusedMesh& mesh, double least_m2) {
    std::vector<int> piece(mesh.vertices.size());
    std::iota(piece.begin(), piece.end(), 0);
    const auto root = [&](int i) {
        while (piece[static_cast<std::size_t>(i)] != i) {
            int& up = piece[static_cast<std::size_t>(i)];
            up = piece[static_cast<std::size_t>(up)];
            i = up;
        }
        return i;
    };
    for (const Eigen::Vector3i& t : mesh.triangles) {
        piece[static_cast<std::size_t>(root(t[1]))] = root(t[0]);
        piece[static_cast<std::size_t>(root(t[2]))] = root(t[0]);
    }
    std::vector<double> area(mesh.vertices.size(), 0.0);
    for (const Eigen::Vector3i& t : mesh.triangles) {
        area[static_cast<std::size_t>(root(t[0]))] += static_cast<double>(area_vector(mesh, t).norm());
    }
    FusedMesh kept;
    std::vector<int> moved(mesh.vertices.size(), -1);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (area[static_cast<std::size_t>(root(mesh.triangles[i][0]))] < least_m2) {
            continue;
        }
        Eigen::Vector3i t;
        for (int k = 0; k < 3; ++k) {
            const auto from = static_cast<std::size_t>(mesh.triangles[i][k]);
            if (moved[from] < 0) {
                moved[from] = static_cast<int>(kept.vertices.size());
                kept.vertices.push_back(mesh.vertices[from]);
            }
            t[k] = moved[from];
        }
        kept.triangles.push_back(t);
        kept.observations.push_back(mesh.observations[i]);
        kept.sigmas.push_back(mesh.sigmas[i]);
    }
    return kept;
}

void set_normals(FusedMesh& mesh) {
    mesh.normals.assign(mesh.vertices.size(), Eigen::Vector3f::Zero());
    for (const Eigen::Vector3i& t : mesh.triangles) {
        const Eigen::Vector3f n = area_vector(mesh, t);
        for (int k = 0; k < 3; ++k) {
            mesh.normals[static_cast<std::size_t>(t[k])] += n;
        }
    }
    for (Eigen::Vector3f& n : mesh.normals) {
        n = n.norm() > 0.0F ? n.normalized() : Eigen::Vector3f(0.0F, 0.0F, 1.0F);
    }
}

}  // namespace

FusedMesh extract_surface(const TsdfVolume& volume, const SurfaceOptions& options) {
    FusedMesh mesh = without_crumbs(SurfaceNets(volume, options).run(), options.min_piece_m2);
    set_normals(mesh);
    return mesh;
}

}  // namespace facet
