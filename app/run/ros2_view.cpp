// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/ros2_view.h"

#include <utility>

namespace facet {
namespace {

constexpr float kOpaque = 1.0F;
constexpr float kGlassy = 0.35F;

Ros2Colour colour_of(std::int32_t plane, float opacity) {
    constexpr std::array<float, 3> kGrey{0.6F, 0.6F, 0.6F};
    const std::array<float, 3> c = plane < 0 ? kGrey : plane_colour(plane);
    return {c[0], c[1], c[2], opacity};
}

bool is_finite(const Ros2Triangle& triangle) {
    return triangle.p[0].allFinite() && triangle.p[1].allFinite() && triangle.p[2].allFinite();
}

void add_if_finite(const Ros2Triangle& triangle, std::vector<Ros2Triangle>& triangles) {
    if (is_finite(triangle)) {
        triangles.push_back(triangle);
    }
}

void add_plane(const ScenePlane& plane, std::vector<Ros2Triangle>& triangles) {
    const auto corner = [&](float along, float across) -> Eigen::Vector3f {
        return plane.centre_W + along * plane.along_W + across * plane.across_W;
    };
    const Ros2Colour colour = colour_of(plane.id, kGlassy);
    add_if_finite({{corner(-1, -1), corner(1, -1), corner(1, 1)}, colour}, triangles);
    add_if_finite({{corner(-1, -1), corner(1, 1), corner(-1, 1)}, colour}, triangles);
}

}  // namespace

Ros2View::Ros2View() {
    for (Box* box : {&inbox_, &taken_}) {
        reserve_most(box->mesh);
        box->landmarks.reserve(kMaxLandmarks);
        box->grid.cells.reserve(kMaxCells);
        box->keyframes.reserve(kMaxKeyframes);
    }
}

void Ros2View::offer(const ViewState& state, const Fillers& fillers) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock.owns_lock()) {
        return;
    }
    if (state.is_keyframe && state.has_pose && inbox_.keyframes.size() < kMaxKeyframes) {
        inbox_.keyframes.push_back(state);
        inbox_.stamp = state.stamp;
    }
    if (state.T_M_W) {
        inbox_.T_M_W = state.T_M_W;
        inbox_.stamp = state.stamp;
    }
    if (fillers.mesh && wants_mesh_) {
        refill(fillers.mesh, inbox_.mesh);
        inbox_.has_mesh = true;
        inbox_.stamp = state.stamp;
    }
    if (fillers.landmarks && wants_landmarks_) {
        inbox_.landmarks.clear();
        fillers.landmarks(inbox_.landmarks);
        inbox_.has_landmarks = true;
        inbox_.stamp = state.stamp;
    }
    if (fillers.grid && wants_grid_) {
        inbox_.grid.cells.clear();
        fillers.grid(inbox_.grid);
        inbox_.has_grid = true;
        inbox_.stamp = state.stamp;
    }
}

void Ros2View::add_path(const Ros2Wishes& wishes, Ros2Scene& scene) {
    for (const ViewState& keyframe : taken_.keyframes) {
        path_.add(keyframe);
        path_is_new_ = true;
    }
    if (!wishes.path || !path_is_new_ || taken_.stamp < next_path_) {
        return;
    }
    path_is_new_ = false;
    next_path_ = taken_.stamp + kPathPeriod;
    scene.has_path = true;
    for (const Se3& pose : path_.poses()) {
        scene.path.push_back({pose.p, pose.q});
    }
}

bool Ros2View::take(const Ros2Wishes& wishes, Ros2Scene& scene) {
    wants_mesh_ = wishes.mesh;
    wants_landmarks_ = wishes.landmarks;
    wants_grid_ = wishes.grid;
    taken_.has_mesh = taken_.has_landmarks = taken_.has_grid = false;
    taken_.T_M_W.reset();
    taken_.keyframes.clear();
    {
        const std::lock_guard lock(mutex_);
        if (inbox_.keyframes.empty() && !inbox_.has_mesh && !inbox_.has_landmarks && !inbox_.has_grid &&
            !inbox_.T_M_W) {
            return false;
        }
        std::swap(inbox_, taken_);
    }
    scene.stamp = taken_.stamp;
    scene.has_map = taken_.T_M_W.has_value();
    if (taken_.T_M_W) {
        scene.map = {taken_.T_M_W->p, taken_.T_M_W->q};
    }
    add_path(wishes, scene);
    scene.has_mesh = taken_.has_mesh;
    if (taken_.has_mesh) {
        for (const ViewFace& face : taken_.mesh.faces) {
            add_if_finite({face.p_W, colour_of(face.plane, kOpaque)}, scene.mesh);
        }
        for (const ViewPlane& plane : taken_.mesh.planes) {
            add_plane(plane, scene.planes);
        }
    }
    scene.has_landmarks = taken_.has_landmarks;
    scene.landmarks.assign(taken_.landmarks.begin(), taken_.landmarks.end());
    scene.has_grid = taken_.has_grid;
    if (taken_.has_grid) {
        const ViewGrid& grid = taken_.grid;
        scene.grid.cell_m = grid.cell_m;
        scene.grid.width = static_cast<std::uint32_t>(grid.width);
        scene.grid.height = static_cast<std::uint32_t>(grid.height);
        scene.grid.corner = grid.corner_W;
        scene.grid.cells.assign(grid.cells.begin(), grid.cells.end());
    }
    return true;
}

}  // namespace facet
