// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/run_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "app/output/ply_file.h"

namespace facet {
namespace {

Eigen::Vector3f area_vector(const SurfaceMesh& mesh, const Eigen::Vector3i& t) {
    const auto p = [&](int k) -> const Eigen::Vector3f& { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    return 0.5F * (p(1) - p(0)).cross(p(2) - p(0));
}

/// Leaves out pieces smaller than `least_m2`, and vertices without triangles.
SurfaceMesh without_crumbs(const SurfaceMesh& mesh, double least_m2) {
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
    SurfaceMesh kept;
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
                kept.normals.push_back(mesh.normals[from]);
                kept.greys.push_back(mesh.greys[from]);
            }
            t[k] = moved[from];
        }
        kept.triangles.push_back(t);
        kept.observations.push_back(mesh.observations[i]);
        kept.sigmas.push_back(mesh.sigmas[i]);
    }
    return kept;
}

}  // namespace

void RunSurface::take(const SurfacePiece& piece, std::uint32_t restart) {
    const Key key{static_cast<std::int32_t>(restart), piece.at.x(), piece.at.y(), piece.at.z()};
    const auto known = pieces_.find(key);
    if (known != pieces_.end()) {
        triangles_ -= known->second.triangles.size();
    }
    if (piece.triangles.empty()) {
        if (known != pieces_.end()) {
            pieces_.erase(known);
        }
        return;
    }
    if (known == pieces_.end() && triangles_ + piece.triangles.size() > max_triangles_) {
        ++dropped_;
        return;
    }
    Piece& kept = known != pieces_.end() ? known->second : pieces_[key];
    kept.vertices.assign(piece.vertices.begin(), piece.vertices.end());
    kept.triangles.assign(piece.triangles.begin(), piece.triangles.end());
    triangles_ += kept.triangles.size();
}

SurfaceMesh RunSurface::mesh(double least_m2) const {
    SurfaceMesh mesh;
    std::map<Key, int> index_of;  // by restart and cell
    std::vector<int> index;
    for (const auto& [at, piece] : pieces_) {
        index.clear();
        for (const SurfaceVertex& v : piece.vertices) {
            Key cell = at;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                cell[axis + 1] = TsdfVolume::kSide * at[axis + 1] + v.cell[axis];
            }
            const auto [known, is_new] = index_of.try_emplace(cell, static_cast<int>(mesh.vertices.size()));
            index.push_back(known->second);
            if (is_new) {
                mesh.vertices.push_back(v.p_W);
                mesh.normals.push_back(v.normal_W);
                mesh.greys.push_back(static_cast<std::uint8_t>(std::clamp(v.grey, 0.0F, 255.0F)));
            }
        }
        for (const SurfaceTriangle& t : piece.triangles) {
            mesh.triangles.push_back({index[t.vertex[0]], index[t.vertex[1]], index[t.vertex[2]]});
            mesh.observations.push_back(t.views);
            mesh.sigmas.push_back(t.sigma_m);
        }
    }
    return without_crumbs(mesh, least_m2);
}

void RunSurface::write(const std::string& path, const std::string& comment, const SurfacePlanes& planes) const {
    const SurfaceMesh mesh = this->mesh();
    std::vector<Eigen::Matrix<std::uint8_t, 3, 1>> colours;
    for (const std::uint8_t grey : mesh.greys) {
        colours.emplace_back(grey, grey, grey);
    }
    std::vector<std::int32_t> plane_ids;
    for (const Eigen::Vector3i& t : mesh.triangles) {
        Eigen::Vector3f p = Eigen::Vector3f::Zero();
        for (int k = 0; k < 3; ++k) {
            p += mesh.vertices[static_cast<std::size_t>(t[k])] / 3.0F;
        }
        plane_ids.push_back(planes.plane_of(p, area_vector(mesh, t).normalized()));
    }
    PlyMesh ply;
    ply.vertices = mesh.vertices;
    ply.normals = mesh.normals;
    ply.colours = colours;
    ply.triangles = mesh.triangles;
    ply.planes = plane_ids;
    ply.observations = mesh.observations;
    ply.sigmas = mesh.sigmas;
    replace_ply(path, comment, ply);
}

}  // namespace facet
