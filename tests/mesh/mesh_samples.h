// SPDX-License-Identifier: BSD-2-Clause
// Meshes for tests.
#pragma once

#include <memory>
#include <random>

#include "mesh/horizon_mesh.h"

namespace facet::test {

/// Adds a landmark's vertex.
inline VertexSlot add_vertex(HorizonMesh& mesh, std::uint32_t id, const Eigen::Vector3d& p_W) {
    const VertexSlot slot = mesh.add_vertex({id}).value();
    mesh.vertex(slot).measured_W = p_W;
    mesh.vertex(slot).covariance_W = 1e-4F * Eigen::Matrix3f::Identity();
    return slot;
}

/// `faces` random triangles of sides about `size` in a box of half widths (10, 10, 3) m, sharing vertices.
inline std::unique_ptr<HorizonMesh> random_mesh(int faces, unsigned seed, double size = 0.6) {
    auto mesh = std::make_unique<HorizonMesh>();
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto vector = [&](double x, double y, double z) {
        const double u = uniform(random);
        const double v = uniform(random);
        return Eigen::Vector3d(x * u, y * v, z * uniform(random));
    };
    // Clusters of k vertices give k (k-1) (k-2) / 6 triangles each: a full mesh needs large ones to have
    // enough vertices.
    constexpr int kMaxCluster = 8;
    const int cluster = faces > 2000 ? kMaxCluster : 4;
    std::uint32_t id = 0;
    while (mesh->face_count() < faces) {
        const Eigen::Vector3d centre = vector(10.0, 10.0, 3.0);
        std::array<VertexSlot, kMaxCluster> vertex{};
        for (int k = 0; k < cluster; ++k) {
            vertex[static_cast<std::size_t>(k)] = add_vertex(*mesh, id++, centre + vector(size, size, size));
        }
        for (int a = 0; a < cluster; ++a) {
            for (int b = a + 1; b < cluster; ++b) {
                for (int c = b + 1; c < cluster && mesh->face_count() < faces; ++c) {
                    const auto at = [&](int k) { return vertex[static_cast<std::size_t>(k)]; };
                    const auto face = mesh->add_face({at(a), at(b), at(c)});
                    if (face.ok()) {
                        mesh->face(face.value()).observations = 1;
                    }
                }
            }
        }
    }
    return mesh;
}

}  // namespace facet::test
