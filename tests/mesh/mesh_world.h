// SPDX-License-Identifier: BSD-2-Clause
// Made-up walls of landmarks, and what the estimator would tell of them at a keyframe.
#pragma once

#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "tests/mesh/keyframe_samples.h"

namespace facet::test {

struct MeshWorld {
    std::vector<std::pair<std::uint32_t, Eigen::Vector3d>> points;
    std::uint32_t next = 0;

    /// A jittered grid of landmarks on a surface x = depth(y, z).
    void wall(double half_y, double half_z, double step, const std::function<double(double, double)>& depth) {
        std::mt19937 random(3);
        std::uniform_real_distribution<double> jitter(-0.2 * step, 0.2 * step);
        for (double y = -half_y; y <= half_y; y += step) {
            for (double z = -half_z; z <= half_z; z += step) {
                const double yy = y + jitter(random);
                const double zz = z + jitter(random);
                points.push_back({next++, {depth(yy, zz), yy, zz}});
            }
        }
    }
};

/// What the estimator would tell: all landmarks within the image are tracked.
inline std::unique_ptr<KeyframeView> view_of(
    const MeshWorld& world, const Se3& T_W_C0, int second,
    const std::function<bool(std::uint32_t)>& is_there = [](std::uint32_t) { return true; }) {
    auto view = std::make_unique<KeyframeView>();
    view->number = static_cast<std::uint32_t>(second);
    view->stamp = {1'000'000'000LL * second};
    view->oldest_stamp = {1'000'000'000LL * (second - 5)};
    view->T_W_C0 = T_W_C0;
    for (const auto& [id, p] : world.points) {
        const Eigen::Vector3d p_C = T_W_C0.inverse() * p;
        Eigen::Vector2d uv;
        if (!is_there(id) || !ok(mesh_camera().project(p_C, uv)) || !mesh_camera().in_image(uv, 1.0)) {
            continue;
        }
        LandmarkSnapshot s;
        s.id = {id};
        s.p_W = p;
        s.covariance_W = 1e-6F * Eigen::Matrix3f::Identity();
        s.chi2 = 1.0F;
        s.depth_m = static_cast<float>(p_C.z());
        s.depth_sigma_m = 1e-3F;
        s.keyframes = 3;
        s.stereo = 3;
        s.first_stamp = {1'000'000'000LL * (second - 2)};
        s.is_tracked = true;
        s.left_xy = p_C.head<2>() / p_C.z();
        s.left_px = uv.cast<float>();
        view->landmarks.push_back(s);
    }
    return view;
}

inline std::unique_ptr<Mesher> make_mesher(const MeshConfig& config = {}) {
    auto mesher = std::make_unique<Mesher>();
    REQUIRE(ok(mesher->configure(config, mesh_camera())));
    return mesher;
}

inline double area_of(const HorizonMesh& mesh) {
    double area = 0.0;
    for (int i = 0; i < mesh.face_end(); ++i) {
        area += mesh.is_face(i) ? static_cast<double>(mesh.face(static_cast<FaceIndex>(i)).area_m2) : 0.0;
    }
    return area;
}

}  // namespace facet::test
