// SPDX-License-Identifier: BSD-2-Clause
// What the mesher makes of points that only one keyframe's stereo pair shows.
#include <catch2/catch.hpp>
#include <vector>

#include "mesh/mesher.h"
#include "tests/mesh/mesh_world.h"
#include "tests/support/allocation_guard.h"

namespace facet::surface_points_test {
namespace {

using Eigen::Vector3d;
using test::area_of;
using test::looking_along_x;
using test::make_mesher;
using test::view_of;
using World = test::MeshWorld;

/// Tells the points of another world as surface points of the view's keyframe, whose pose and those before are given.
void add_surface(const World& world, const std::vector<KeyframePose>& keyframes, KeyframeView& view) {
    constexpr std::uint32_t kFirst = 100000;
    const auto seen = view_of(world, view.T_W_C0, static_cast<int>(view.number));
    for (LandmarkSnapshot& s : seen->landmarks) {
        s.id.value += kFirst * view.number;
        s.keyframes = s.stereo = 1;
        s.first_stamp = view.stamp;
        view.surface.push_back(s);
    }
    for (const KeyframePose& k : keyframes) {
        view.keyframes.push_back(k);
    }
}

TEST_CASE("surface points refine the mesh, move with their keyframe and leave with it") {
    World landmarks;
    landmarks.wall(1.0, 0.8, 0.4, [](double, double) { return 3.0; });
    World between;
    between.wall(1.1, 0.9, 0.23, [](double, double) { return 3.0; });
    const Se3 here = looking_along_x({0.0, 0.0, 0.0});
    const auto coarse = make_mesher();
    coarse->update(*view_of(landmarks, here, 10), {});
    const auto mesher = make_mesher();
    auto view = view_of(landmarks, here, 10);
    add_surface(between, {{view->stamp, here}}, *view);
    mesher->update(*view, {});
    const HorizonMesh& mesh = mesher->mesh();
    CHECK(mesh.face_count() > 2 * coarse->mesh().face_count());
    CHECK(area_of(mesh) > area_of(coarse->mesh()));
    const Timestamp first = view->stamp;
    // The next keyframe looks elsewhere; the window has learned that the first one stood 2 cm farther back.
    const Se3 corrected{here.q, here.p - Vector3d(0.02, 0.0, 0.0)};
    const Se3 away = looking_along_x({50.0, 0.0, 0.0});
    view = view_of(landmarks, here, 11);
    for (LandmarkSnapshot& s : view->landmarks) {
        s.p_W.x() -= 0.02;
        s.is_tracked = false;
        s.unseen_keyframes = 10;
    }
    view->T_W_C0 = away;
    view->keyframes.push_back({first, corrected});
    view->keyframes.push_back({view->stamp, away});
    const int faces = mesh.face_count();
    {
        const test::AllocationGuard guard;
        mesher->update(*view, {});
        CHECK(guard.allocations() == 0);
    }
    CHECK(mesh.face_count() == faces);
    for (int i = 0; i < mesh.face_end(); ++i) {
        for (int k = 0; k < 3; ++k) {
            REQUIRE(mesh.corner(mesh.face(static_cast<FaceIndex>(i)), k).x() == Approx(2.98));
        }
    }
    // The first keyframe leaves the window: what hangs on it departs.
    view->number = 12;
    view->stamp = {12'000'000'000LL};
    view->oldest_stamp = {11'000'000'000LL};
    view->keyframes.erase_at(0);
    view->keyframes.push_back({view->stamp, away});
    mesher->update(*view, {});
    CHECK(mesher->departed().size() > static_cast<std::size_t>(faces) / 2);
    CHECK(mesher->counters().judged_bad == 0);
    for (int i = 0; i < mesh.vertex_end(); ++i) {
        REQUIRE_FALSE((mesh.is_vertex(i) && mesh.vertex(static_cast<VertexSlot>(i)).is_surface_point));
    }
}

TEST_CASE("depth along a ray lies between the corners of the triangle it passes, and nothing is said beside them") {
    // GIVEN a wall that runs away from the camera: every triangle spans some depth
    World slope;
    slope.wall(1.0, 0.8, 0.2, [](double y, double) { return 3.0 + 0.5 * y; });
    const auto mesher = make_mesher();
    DepthPrior prior{1.0, 2.0};
    CHECK_FALSE(mesher->depth_prior({0.0, 0.0}, prior));  // before the first keyframe
    const auto view = view_of(slope, looking_along_x({0.0, 0.0, 0.0}), 10);
    mesher->update(*view, {});
    // WHEN it is asked for along rays through the wall
    for (double u = -0.25; u <= 0.25; u += 0.05) {
        INFO(u);
        REQUIRE(mesher->depth_prior({u, 0.02}, prior));
        // THEN the wall's own depth is within: the ray (1, -u, -0.02) meets x = 3 + y / 2
        const double depth = 3.0 / (1.0 + 0.5 * u);
        CHECK(prior.farthest <= 1.0 / depth);
        CHECK(prior.nearest >= 1.0 / depth);
        CHECK(prior.nearest - prior.farthest < 0.05);
    }
    // AND rays that pass the wall leave what is there untouched.
    prior = {1.0, 2.0};
    CHECK_FALSE(mesher->depth_prior({0.8, 0.0}, prior));
    CHECK(prior.farthest == 1.0);
    CHECK(prior.nearest == 2.0);
    // What is known less well leaves more room.
    DepthPrior sure;
    REQUIRE(mesher->depth_prior({0.1, 0.02}, sure));
    for (LandmarkSnapshot& s : view->landmarks) {
        s.depth_sigma_m = 0.03F;
    }
    mesher->update(*view, {});
    REQUIRE(mesher->depth_prior({0.1, 0.02}, prior));
    CHECK(prior.farthest < sure.farthest);
    CHECK(prior.nearest > sure.nearest);
}

}  // namespace
}  // namespace facet::surface_points_test
