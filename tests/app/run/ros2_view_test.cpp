// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/ros2_view.h"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/allocation_guard.h"

namespace facet::ros2_view_test {
namespace {

constexpr Ros2Wishes kEverything{true, true, true, true};

ViewState keyframe_at(double seconds) {
    ViewState state;
    state.stamp.ns = static_cast<std::int64_t>(seconds * 1e9);
    state.is_keyframe = true;
    state.T_W_B.p.x() = seconds;
    return state;
}

ViewFace face_on(std::int32_t plane, float x = 0.0F) {
    return {{Eigen::Vector3f(x, 0, 0), Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, 1, 0)}, plane};
}

FlightViewer::Fillers some_fillers() {
    FlightViewer::Fillers fillers;
    fillers.mesh = [](ViewMesh& mesh) {
        mesh.faces.push_back(face_on(-1));
        mesh.faces.push_back(face_on(2));
        mesh.faces.push_back(face_on(2, std::numeric_limits<float>::quiet_NaN()));
        mesh.planes.push_back({.id = 2, .along_W = Eigen::Vector3f(2, 0, 0), .across_W = Eigen::Vector3f(0, 1, 0)});
    };
    fillers.landmarks = [](std::vector<Eigen::Vector3f>& points) { points.emplace_back(1.0F, 2.0F, 3.0F); };
    fillers.grid = [](ViewGrid& grid) {
        grid.cell_m = 0.1F;
        grid.width = 2;
        grid.height = 1;
        grid.corner_W = {-1.0, -2.0, 3.0};
        grid.cells.push_back(0);
        grid.cells.push_back(100);
    };
    return fillers;
}

TEST_CASE("what is listened to becomes a scene, in the colours of its planes") {
    Ros2View view;
    Ros2Scene scene;
    CHECK_FALSE(view.take(kEverything, scene));
    const FlightViewer::Fillers fillers = some_fillers();
    std::uint64_t allocations = 0;
    {
        const test::AllocationGuard guard;
        view.offer(keyframe_at(3.0), fillers);
        allocations = guard.allocations();
    }
    CHECK(allocations == 0);
    REQUIRE(view.take(kEverything, scene));
    CHECK(scene.stamp == Timestamp{3'000'000'000});
    REQUIRE(scene.has_mesh);
    REQUIRE(scene.mesh.size() == 2);  // the one that is not finite is left out
    CHECK(scene.mesh[0].colour != scene.mesh[1].colour);
    CHECK(scene.mesh[1].colour[3] == 1.0F);
    REQUIRE(scene.planes.size() == 2);
    CHECK(scene.planes[0].p[1] == Eigen::Vector3f(2, -1, 0));
    CHECK(scene.planes[0].colour[0] == scene.mesh[1].colour[0]);
    REQUIRE(scene.landmarks.size() == 1);
    CHECK(scene.landmarks[0].z() == 3.0F);
    REQUIRE(scene.has_grid);
    CHECK(scene.grid.width == 2);
    CHECK(scene.grid.corner == Eigen::Vector3d(-1.0, -2.0, 3.0));
    CHECK(scene.grid.cells == std::vector<std::int8_t>{0, 100});
    REQUIRE(scene.path.size() == 1);
    CHECK(scene.path[0].p.x() == 3.0);
    Ros2Scene none;
    CHECK_FALSE(view.take(kEverything, none));
}

TEST_CASE("the newest frame of the odometry in the map goes out, while it is known") {
    Ros2View view;
    Ros2Scene scene;
    ViewState state = keyframe_at(3.0);
    state.is_keyframe = false;
    state.T_M_W = Se3{Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0}};
    view.offer(state, {});
    state.stamp = {3'100'000'000};
    state.T_M_W->p.x() = 2.0;
    view.offer(state, {});
    REQUIRE(view.take({}, scene));
    CHECK(scene.stamp == Timestamp{3'100'000'000});
    REQUIRE(scene.has_map);
    CHECK(scene.map.p.x() == 2.0);
    view.offer(keyframe_at(3.2), {});
    REQUIRE(view.take({}, scene));
    CHECK_FALSE(scene.has_map);
}

TEST_CASE("what nobody listens to is not copied") {
    Ros2View view;
    Ros2Scene scene;
    CHECK_FALSE(view.take({}, scene));
    FlightViewer::Fillers fillers;
    fillers.mesh = [](ViewMesh&) { FAIL("is not wanted"); };
    fillers.landmarks = [](std::vector<Eigen::Vector3f>&) { FAIL("is not wanted"); };
    fillers.grid = [](ViewGrid&) { FAIL("is not wanted"); };
    view.offer(keyframe_at(3.0), fillers);
    REQUIRE(view.take({}, scene));  // the path goes on
    CHECK_FALSE(scene.has_mesh);
    CHECK_FALSE(scene.has_landmarks);
    CHECK_FALSE(scene.has_path);
    CHECK_FALSE(scene.has_grid);
}

TEST_CASE("the path holds all keyframes, is given once a second, and restarts with the estimator") {
    Ros2View view;
    const auto path_after = [&](double seconds, std::uint32_t resets = 0) {
        ViewState state = keyframe_at(seconds);
        state.health.reset_counter = resets;
        view.offer(state, {});
        Ros2Scene scene;
        REQUIRE(view.take(kEverything, scene));
        return scene.path.size();
    };
    CHECK(path_after(1.0) == 1);
    CHECK(path_after(1.5) == 0);
    CHECK(path_after(2.1) == 3);
    CHECK(path_after(3.2, 1) == 1);
    ViewState lost = keyframe_at(5.0);
    lost.has_pose = false;
    view.offer(lost, {});
    Ros2Scene scene;
    CHECK_FALSE(view.take(kEverything, scene));
}

}  // namespace
}  // namespace facet::ros2_view_test
