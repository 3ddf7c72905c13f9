// SPDX-License-Identifier: BSD-2-Clause
// The mesher on made-up keyframes: landmarks on walls seen by a camera that looks along W's x axis.
#include "mesh/mesher.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <random>
#include <set>

#include "tests/mesh/mesh_world.h"
#include "tests/support/allocation_guard.h"

namespace facet::mesher_test {
namespace {

using Eigen::Vector3d;
using test::area_of;
using test::looking_along_x;
using test::make_mesher;
using test::view_of;
using World = test::MeshWorld;

void require_no_duplicates(const HorizonMesh& mesh) {
    std::set<std::set<VertexSlot>> seen;
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (mesh.is_face(i)) {
            const auto& v = mesh.face(static_cast<FaceIndex>(i)).vertex;
            REQUIRE(seen.insert({v[0], v[1], v[2]}).second);
        }
    }
}

TEST_CASE("a flat wall becomes one layer of faces that look at the camera, and is confirmed, not doubled") {
    World world;
    world.wall(1.5, 1.0, 0.25, [](double, double) { return 3.0; });
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    const HorizonMesh& mesh = mesher->mesh();
    const int faces = mesh.face_count();
    CHECK(faces > 150);
    CHECK(area_of(mesh) == Approx(6.0).epsilon(0.15));
    for (int i = 0; i < mesh.face_end(); ++i) {
        REQUIRE(mesh.face(static_cast<FaceIndex>(i)).normal_W.x() == Approx(-1.0F));
    }
    for (int k = 1; k <= 6; ++k) {
        mesher->update(*view_of(world, looking_along_x({0.05 * k, 0.08 * k, 0.0}), 10 + k), {});
    }
    CHECK(area_of(mesh) == Approx(6.0).epsilon(0.15));
    CHECK(mesh.face_count() < 1.1 * faces);
    require_no_duplicates(mesh);
    CHECK(mesher->counters().confirmed > 5U * static_cast<unsigned>(faces));
    CHECK(mesher->counters().contradicted == 0);
    CHECK(std::any_of(&mesh.face(0), &mesh.face(0) + mesh.face_end(),
                      [](const MeshFace& f) { return f.observations == 7; }));
}

TEST_CASE("vertices move with their landmarks") {
    World world;
    world.wall(1.0, 0.8, 0.3, [](double, double) { return 3.0; });
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    for (auto& [id, p] : world.points) {
        p.x() += 0.02;
    }
    mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 11), {});
    for (int i = 0; i < mesher->mesh().face_end(); ++i) {
        REQUIRE(mesher->mesh().centroid(mesher->mesh().face(static_cast<FaceIndex>(i))).x() == Approx(3.02));
    }
}

TEST_CASE("there is no surface between a box in front of a wall and the wall") {
    World world;
    const auto depth = [](double y, double z) { return std::abs(y) < 0.55 && std::abs(z) < 0.55 ? 2.0 : 4.0; };
    world.wall(1.6, 1.2, 0.2, depth);
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    const HorizonMesh& mesh = mesher->mesh();
    CHECK(mesh.face_count() > 100);
    for (int i = 0; i < mesh.face_end(); ++i) {
        REQUIRE(std::abs(mesh.face(static_cast<FaceIndex>(i)).normal_W.x()) > 0.99F);
    }
    const auto& verdicts = mesher->counters().verdicts;
    CHECK(verdicts[static_cast<std::size_t>(FaceVerdict::kDepthStep)] +
              verdicts[static_cast<std::size_t>(FaceVerdict::kElongation)] +
              verdicts[static_cast<std::size_t>(FaceVerdict::kGrazing)] +
              verdicts[static_cast<std::size_t>(FaceVerdict::kSideLength)] >
          20);
}

TEST_CASE("a slanted floor is kept although it is steep in depth") {
    World world;
    world.wall(1.0, 0.5, 0.2, [](double, double z) { return 3.0 + 2.5 * z; });
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    CHECK(area_of(mesher->mesh()) > 0.75 * 2.0 * 1.0 * std::hypot(1.0, 2.5));
}

TEST_CASE("a strong edge in the image between two depths forbids a face, a plain image does not") {
    World world;
    world.wall(1.0, 0.6, 0.25, [](double y, double) { return y > 0.0 ? 3.0 : 3.3; });
    std::vector<std::uint8_t> pixels(752 * 480, 100);
    const ImageView image{pixels.data(), 752, 480, 752};
    MeshConfig config;
    config.faces.coplanar_m = 0.0;
    const auto plain = make_mesher(config);
    plain->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), image);
    for (int v = 0; v < 480; ++v) {
        std::fill_n(pixels.begin() + v * 752 + 376, 376, std::uint8_t{200});  // right half, y < 0: the farther part
    }
    const auto edged = make_mesher(config);
    edged->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), image);
    const auto gradient = static_cast<std::size_t>(FaceVerdict::kGradient);
    CHECK(plain->counters().verdicts[gradient] == 0);
    CHECK(edged->counters().verdicts[gradient] > 3);
    CHECK(edged->mesh().face_count() < plain->mesh().face_count());
}

TEST_CASE("a landmark that leaves the horizon takes its faces, and the hole it leaves in a wall is closed") {
    World world;
    world.wall(1.2, 0.8, 0.25, [](double, double) { return 3.0; });
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    const double area = area_of(mesher->mesh());
    std::uint32_t middle = 0;  // the landmark nearest to the middle of the wall
    for (const auto& [id, p] : world.points) {
        if ((p - Vector3d(3.0, 0.0, 0.0)).norm() < (world.points[middle].second - Vector3d(3.0, 0.0, 0.0)).norm()) {
            middle = id;
        }
    }
    const int degree = mesher->mesh().faces_at(mesher->mesh().find_vertex({middle}).value());
    // The camera looks away when it leaves: nothing else could close the hole. The others are still known.
    auto view = view_of(world, looking_along_x({0.0, 0.0, 0.0}), 14, [=](std::uint32_t id) { return id != middle; });
    for (LandmarkSnapshot& s : view->landmarks) {
        s.is_tracked = false;
        s.unseen_keyframes = 10;
    }
    view->T_W_C0 = looking_along_x({50.0, 0.0, 0.0});
    mesher->update(*view, {});
    CHECK(static_cast<int>(mesher->departed().size()) == degree);
    CHECK_FALSE(mesher->mesh().find_vertex({middle}).ok());
    CHECK(mesher->counters().departed == static_cast<std::uint64_t>(degree));
    CHECK(mesher->counters().holes_filled == 1);
    CHECK(mesher->counters().fill_faces == static_cast<std::uint64_t>(degree - 2));
    CHECK(area_of(mesher->mesh()) == Approx(area).epsilon(1e-6));
    int fill = 0;
    for (int i = 0; i < mesher->mesh().face_end(); ++i) {
        const MeshFace& f = mesher->mesh().face(static_cast<FaceIndex>(i));
        fill += mesher->mesh().is_face(i) && f.is_fill ? 1 : 0;
        REQUIRE((!mesher->mesh().is_face(i) || f.normal_W.x() < -0.99F));
    }
    CHECK(fill == degree - 2);
}

TEST_CASE("a landmark that the smoother rejects takes its faces, which do not count as departed") {
    World world;
    world.wall(1.0, 0.8, 0.3, [](double, double) { return 3.0; });
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    // Its first keyframe is still in the window.
    mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 11, [](std::uint32_t id) { return id != 20; }),
                   {});
    CHECK(mesher->departed().empty());
    CHECK(mesher->counters().judged_bad > 0);
    CHECK_FALSE(mesher->mesh().find_vertex({20}).ok());
}

TEST_CASE("when the window restarts, the whole mesh departs and no face spans the restart") {
    const test::WallFlight flight;
    const auto mesher = make_mesher();
    for (int k = 0; k < 10; ++k) {
        mesher->update(*flight.view(k), {});
    }
    const HorizonMesh& mesh = mesher->mesh();
    std::size_t before = 0;
    std::set<std::set<std::uint32_t>> old;
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (mesh.is_face(i)) {
            const auto& f = mesh.face(static_cast<FaceIndex>(i));
            before += f.is_fill ? 0 : 1;
            old.insert(
                {mesh.landmark(f.vertex[0]).value, mesh.landmark(f.vertex[1]).value, mesh.landmark(f.vertex[2]).value});
        }
    }
    REQUIRE(before > 200);
    const std::uint64_t departed = mesher->counters().departed;
    const std::uint64_t doubtful = mesher->counters().doubtful;
    // The next view is of a window that began at keyframe 11. Tracks went on: landmarks keep their ids, but the new
    // estimate puts them 20 cm farther.
    auto view = flight.view(12, 11);
    std::size_t known = 0;
    for (LandmarkSnapshot& s : view->landmarks) {
        s.p_W.x() += 0.2;
        known += mesh.find_vertex(s.id).ok() ? 1 : 0;
    }
    view->T_W_C0.p.x() += 0.2;
    REQUIRE(known > 100);
    mesher->update(*view, {});
    CHECK(mesher->departed().size() + mesher->counters().doubtful - doubtful == before);
    CHECK(mesher->counters().departed + mesher->counters().doubtful == departed + doubtful + old.size());
    for (const DepartedFace& face : mesher->departed()) {
        REQUIRE(old.count({face.landmark[0].value, face.landmark[1].value, face.landmark[2].value}) == 1);
        for (const Eigen::Vector3f& p : face.p_W) {
            REQUIRE(p.x() < 3.1F);  // as it stood
        }
    }
    int faces = 0;
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (mesh.is_face(i)) {
            ++faces;
            const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
            REQUIRE(face.born == mesher->counters().updates);
            for (int k = 0; k < 3; ++k) {
                REQUIRE(mesh.corner(face, k).x() > 2.75);
            }
        }
    }
    CHECK(faces > 100);
    mesher->update(*flight.view(13, 11), {});
    CHECK(mesher->departed().size() < before / 10);  // only once
}

TEST_CASE("over a long run the mesh stays as large as its horizon, and nothing allocates") {
    const test::WallFlight flight;
    const auto mesher = make_mesher();
    std::array<int, 2> most_faces{};
    std::array<int, 2> most_vertices{};
    std::uint64_t allocations = 0;
    constexpr int kUpdates = 240;
    for (int k = 0; k < kUpdates; ++k) {
        const auto view = flight.view(k);
        const test::AllocationGuard guard;
        mesher->update(*view, {});
        allocations += guard.allocations();
        const std::size_t half = k < kUpdates / 2 ? 0 : 1;
        most_faces[half] = std::max(most_faces[half], mesher->mesh().face_count());
        most_vertices[half] = std::max(most_vertices[half], mesher->mesh().vertex_count());
        REQUIRE(mesher->mesh().vertex_count() <= static_cast<int>(view->landmarks.size()));
    }
    CHECK(allocations == 0);
    CHECK(mesher->counters().departed > 2000);  // the camera flew along 36 m of wall
    CHECK(mesher->counters().dropped == 0);
    CHECK(most_faces[0] < 3000);
    CHECK(most_faces[1] <= 1.15 * most_faces[0]);
    CHECK(most_vertices[1] <= 1.15 * most_vertices[0]);
    CHECK(mesher->mesh().face_end() <= 2 * most_faces[0]);  // indices are used again
    // What came has gone again or is there.
    const MeshCounters& c = mesher->counters();
    CHECK(c.added + c.fill_faces == c.superseded + c.contradicted + c.misshapen + c.judged_bad + c.departed +
                                        c.doubtful + c.dropped + c.flown_through +
                                        static_cast<std::uint64_t>(mesher->mesh().face_count()));
}

TEST_CASE("a face with things seen behind it leaves after enough contradictions") {
    World world;
    for (const Vector3d& p :
         {Vector3d(2.0, -0.3, -0.3), Vector3d(2.0, 0.3, -0.3), Vector3d(2.0, 0.0, 0.3), Vector3d(2.0, 0.6, 0.3)}) {
        world.points.push_back({world.next++, p});
    }
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    REQUIRE(mesher->mesh().face_count() == 2);
    world.wall(1.5, 1.0, 0.2, [](double, double) { return 4.0; });
    int updates = 0;
    while (mesher->counters().contradicted == 0 && updates < 10) {
        ++updates;
        mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10 + updates), {});
    }
    CHECK(mesher->counters().contradicted >= 1);
    CHECK(updates >= 2);
}

TEST_CASE("a recent landmark refines the mesh unless the tracked ones show that it is hidden") {
    World world;
    world.wall(1.2, 0.9, 0.4, [](double, double) { return 3.0; });
    const std::uint32_t on_wall = world.next++;
    const std::uint32_t behind = world.next++;
    const std::uint32_t in_front = world.next++;
    world.points.push_back({on_wall, {3.0, 0.19, 0.21}});
    world.points.push_back({behind, {4.0, -0.25, -0.25}});
    world.points.push_back({in_front, {2.0, 0.13, -0.12}});
    auto view = view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10);
    for (LandmarkSnapshot& s : view->landmarks) {
        if (s.id.value >= on_wall) {
            s.is_tracked = false;
            s.unseen_keyframes = 1;
        }
    }
    const auto mesher = make_mesher();
    mesher->update(*view, {});
    CHECK(mesher->mesh().find_vertex({on_wall}).ok());
    CHECK_FALSE(mesher->mesh().find_vertex({behind}).ok());
    CHECK_FALSE(mesher->mesh().find_vertex({in_front}).ok());
}

TEST_CASE("a full mesh drops the least supported faces, keeps its capacity and needs no heap") {
    // GIVEN a rough cloud of 2000 landmarks and filters that let everything pass: every keyframe tracks another 450 of
    // them, so that its faces are new ones and lie on no face there is
    MeshConfig config;
    config.faces.min_side_ratio = config.faces.min_elongation = 0.0;
    config.faces.max_grazing_deg = 90.0;
    config.faces.max_step_slope = config.faces.gradient_step_slope = 100.0;
    config.faces.lonely_neighbours = 0;
    const auto mesher = make_mesher(config);
    std::mt19937 random(8);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    World world;
    for (int i = 0; i < 2000; ++i) {
        const double y = 1.8 * uniform(random);
        const double z = 1.0 * uniform(random);
        world.points.push_back({world.next++, {2.5 + 0.4 * uniform(random), y, z}});
    }
    std::vector<std::unique_ptr<KeyframeView>> views;
    for (int k = 0; k < 25; ++k) {
        views.push_back(view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10 + k));
        for (LandmarkSnapshot& s : views.back()->landmarks) {
            s.is_tracked = random() % 2000 < 450;
            s.unseen_keyframes = s.is_tracked ? 0 : 1;
        }
    }
    // WHEN all are taken in
    const test::AllocationGuard guard;
    int most = 0;
    for (const auto& view : views) {
        mesher->update(*view, {});
        most = std::max(most, mesher->mesh().face_count());
    }
    const std::uint64_t allocations = guard.allocations();
    // THEN the newest keyframe's faces are there, and the mesh is as full as it may be
    CHECK(allocations == 0);
    CHECK(most <= kMaxMeshFaces);
    CHECK(most > kMaxMeshFaces - 1000);
    CHECK(mesher->counters().dropped > 1000);
    require_no_duplicates(mesher->mesh());
    int newest = 0;
    for (int i = 0; i < mesher->mesh().face_end(); ++i) {
        newest +=
            mesher->mesh().is_face(i) && mesher->mesh().face(static_cast<FaceIndex>(i)).last_observed == 25 ? 1 : 0;
    }
    CHECK(newest > 500);
}

TEST_CASE("a large face needs a neighbour in its plane") {
    World world;
    const std::array<Vector3d, 4> corner{Vector3d(3.0, -0.48, -0.4), Vector3d(3.0, 0.48, -0.4),
                                         Vector3d(3.0, 0.0, 0.48), Vector3d(3.0, 0.96, 0.48)};
    for (std::size_t i = 0; i < 3; ++i) {
        world.points.push_back({world.next++, corner[i]});
    }
    const auto alone = make_mesher();
    alone->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    CHECK(alone->mesh().face_count() == 0);
    CHECK(alone->counters().verdicts[static_cast<std::size_t>(FaceVerdict::kLonely)] == 1);
    world.points.push_back({world.next++, corner[3]});
    const auto pair = make_mesher();
    pair->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    CHECK(pair->mesh().face_count() == 2);
}

TEST_CASE("a bare wall with points far apart is one surface, something bent is not") {
    // Columns and rows 1.3 m apart: every side is beyond max_side_m, the diagonals are 1.84 m.
    const auto posts = [](double bend) {
        World world;
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 3; ++row) {
                world.points.push_back({world.next++,
                                        {4.0 + (column > 1 ? bend * (row + 1) * (row + 1) : 0.0), 1.3 * (column - 1.5),
                                         1.3 * (row - 1.0)}});
            }
        }
        return world;
    };
    MeshConfig config;
    const auto flat = make_mesher(config);
    flat->update(*view_of(posts(0.0), looking_along_x({0.0, 0.0, 0.0}), 10), {});
    const double whole = 3.9 * 2.6;
    CHECK(area_of(flat->mesh()) > 0.6 * whole);
    CHECK(area_of(flat->mesh()) <= Approx(whole));
    // The right half is bent back: what is or leads there has at most one neighbour in its plane.
    const auto stepped = make_mesher(config);
    stepped->update(*view_of(posts(0.3), looking_along_x({0.0, 0.0, 0.0}), 10), {});
    for (int i = 0; i < stepped->mesh().face_end(); ++i) {
        const MeshFace& face = stepped->mesh().face(static_cast<FaceIndex>(i));
        REQUIRE((!stepped->mesh().is_face(i) || std::abs(face.normal_W.x()) > 0.999F));
    }
    config.faces.max_flat_side_m = 1.5;
    const auto shorter = make_mesher(config);
    shorter->update(*view_of(posts(0.0), looking_along_x({0.0, 0.0, 0.0}), 10), {});
    CHECK(shorter->mesh().face_count() == 0);
}

TEST_CASE("a face stays as long as newer ones do not cover it up to its corners") {
    // Two triangles of landmarks 0 to 3, then a finer mesh over all but the last 10 cm of corner 1.
    World world;
    for (const Vector3d& p :
         {Vector3d(3.0, 0.0, 0.0), Vector3d(3.0, 0.6, 0.0), Vector3d(3.0, 0.3, 0.5), Vector3d(3.0, -0.3, 0.5)}) {
        world.points.push_back({world.next++, p});
    }
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    REQUIRE(mesher->mesh().face_count() == 2);
    for (int i = -5; i <= 5; ++i) {
        for (int j = -1; j <= 6; ++j) {
            world.points.push_back({world.next++, {3.0, 0.1 * i, 0.1 * j + 0.01}});
        }
    }
    auto view = view_of(world, looking_along_x({0.0, 0.0, 0.0}), 11);
    for (LandmarkSnapshot& s : view->landmarks) {
        s.is_tracked = s.id.value > 3;
        s.unseen_keyframes = s.is_tracked ? 0 : 20;
    }
    mesher->update(*view, {});
    const HorizonMesh& mesh = mesher->mesh();
    const auto slot = [&](std::uint32_t id) { return mesh.find_vertex({id}).value_or(0); };
    CHECK(mesher->counters().superseded == 1);
    CHECK_FALSE(mesh.find_vertex({3}).ok());  // its only face was covered whole
    REQUIRE(mesh.find_vertex({1}).ok());
    CHECK(mesh.find_face({slot(0), slot(1), slot(2)}) != HorizonMesh::kNoFace);
}

TEST_CASE("no landmark at all, and a configuration out of range") {
    MeshConfig config;
    config.max_depth_m = -1.0;
    CHECK(std::make_unique<Mesher>()->configure(config, test::mesh_camera()) == Status::kInvalidArgument);
    const auto empty = make_mesher();
    empty->update(*view_of({}, looking_along_x({0.0, 0.0, 0.0}), 10), {});
    CHECK(empty->mesh().face_count() == 0);
}

}  // namespace
}  // namespace facet::mesher_test
