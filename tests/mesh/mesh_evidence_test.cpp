// SPDX-License-Identifier: BSD-2-Clause
// What removes faces from the mesh, and what does not: contradictions, flights through them, time, simultaneous
// departures, keyframes dropped as redundant.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/mesh/mesh_world.h"

namespace facet::mesh_evidence_test {
namespace {

using Eigen::Vector3d;
using test::area_of;
using test::looking_along_x;
using test::make_mesher;
using test::view_of;
using World = test::MeshWorld;

const Se3 kHere = looking_along_x({0.0, 0.0, 0.0});

void forget_tracks(KeyframeView& view) {
    for (LandmarkSnapshot& s : view.landmarks) {
        s.is_tracked = false;
        s.unseen_keyframes = 10;
    }
}

TEST_CASE("surface points of a keyframe dropped as redundant stay, and move with a neighbour") {
    // GIVEN three keyframes, of which the second has measured a wall of surface points
    World wall;
    wall.wall(1.0, 0.8, 0.3, [](double, double) { return 3.0; });
    constexpr std::int64_t kSecond = 1'000'000'000LL;
    const auto pose_at = [](int k) { return looking_along_x({0.02 * k, 0.0, 0.0}); };
    const auto mesher = make_mesher();
    auto view = view_of(wall, pose_at(1), 11);
    for (const LandmarkSnapshot& s : view->landmarks) {
        view->surface.push_back(s);
        view->surface.back().keyframes = 1;
        view->surface.back().first_stamp = view->stamp;
    }
    view->landmarks.clear();
    view->oldest_stamp = {10 * kSecond};
    view->keyframes.push_back({{10 * kSecond}, pose_at(0)});
    view->keyframes.push_back({{11 * kSecond}, pose_at(1)});
    mesher->update(*view, {});
    const int faces = mesher->mesh().face_count();
    REQUIRE(faces > 50);
    // WHEN the window drops it, keeps the first one, and looks elsewhere
    const auto look_away = [&](int second, std::int64_t oldest, double shift) {
        auto away = view_of({}, looking_along_x({50.0, 0.0, 0.0}), second);
        away->oldest_stamp = {oldest * kSecond};
        if (oldest == 10) {
            const Se3 first = pose_at(0);
            away->keyframes.push_back({{10 * kSecond}, {first.q, first.p + Vector3d(shift, 0.0, 0.0)}});
        }
        away->keyframes.push_back({away->stamp, away->T_W_C0});
        mesher->update(*away, {});
    };
    look_away(12, 10, 0.0);
    // THEN the faces are still there, none is judged bad, and they move with the keyframe that was kept
    CHECK(mesher->mesh().face_count() == faces);
    CHECK(mesher->counters().judged_bad == 0);
    look_away(13, 10, 0.05);
    REQUIRE(mesher->mesh().face_count() == faces);
    for (int i = 0; i < mesher->mesh().vertex_end(); ++i) {
        if (mesher->mesh().is_vertex(i)) {
            REQUIRE(mesher->mesh().vertex(static_cast<VertexSlot>(i)).shown_W().x() == Approx(3.05));
        }
    }
    // AND depart with it.
    look_away(14, 13, 0.0);
    CHECK(static_cast<int>(mesher->departed().size()) == faces);
    CHECK(mesher->mesh().face_count() == 0);
}

TEST_CASE("a face survives views that refuse its triangle without evidence against the surface") {
    World world;
    world.wall(1.0, 0.8, 0.3, [](double, double) { return 3.0; });
    const auto mesher = make_mesher();
    for (int k = 0; k < 3; ++k) {
        mesher->update(*view_of(world, kHere, 10 + k), {});
    }
    const double area = area_of(mesher->mesh());
    REQUIRE(area > 2.0);
    // Four views from beyond max_depth_m.
    for (int k = 3; k < 7; ++k) {
        mesher->update(*view_of(world, looking_along_x({-6.0, 0.0, 0.0}), 10 + k), {});
    }
    CHECK(mesher->counters().contradicted == 0);
    CHECK(area_of(mesher->mesh()) == Approx(area));
}

/// A pane of two faces, which meet at y = 0.
World pane(double x) {
    World world;
    for (const auto& [y, z] :
         {std::pair{-0.55, 0.0}, std::pair{0.0, -0.33}, std::pair{0.55, 0.0}, std::pair{0.0, 0.33}}) {
        world.points.push_back({world.next++, {x, y, z}});
    }
    return world;
}

TEST_CASE("what is seen through any part of a face contradicts it, also if a corner is beside the camera") {
    // GIVEN a pane 1.5 m ahead
    World world = pane(1.5);
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, kHere, 10), {});
    REQUIRE(mesher->mesh().face_count() == 2);
    // WHEN the camera stands beside a corner of it, too near for that to be ahead, and sees points through the rest
    const Se3 beside{Eigen::Quaterniond(Eigen::AngleAxisd(0.9, Vector3d::UnitZ())) * kHere.q,
                     Vector3d(1.4, -0.55, 0.0)};
    World seen;
    for (double z = -0.2; z <= 0.21; z += 0.2) {
        for (double y = 0.6; y <= 2.01; y += 0.2) {
            seen.points.push_back({200 + seen.next++, {3.5, y, z}});
        }
    }
    const auto keep_pane = [&](KeyframeView& view) {
        const auto all = view_of(world, kHere, static_cast<int>(view.number));
        auto landmarks = view.landmarks;
        view.landmarks.clear();
        for (LandmarkSnapshot& s : all->landmarks) {
            s.is_tracked = false;
            s.unseen_keyframes = 10;
            view.landmarks.push_back(s);
        }
        for (const LandmarkSnapshot& s : landmarks) {
            view.landmarks.push_back(s);
        }
    };
    for (int k = 1; k <= 4; ++k) {
        auto view = view_of(seen, beside, 10 + k);
        REQUIRE(view->landmarks.size() > 5);
        keep_pane(*view);
        mesher->update(*view, {});
    }
    // THEN the faces through which they are seen are gone.
    CHECK(mesher->counters().contradicted >= 1);
}

TEST_CASE("a face through which the camera has flown is gone") {
    World world = pane(1.0);
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, kHere, 10), {});
    REQUIRE(mesher->mesh().face_count() == 2);
    const auto fly_to = [&](const Vector3d& p, int second) {
        auto view = view_of(world, kHere, second);
        forget_tracks(*view);
        view->T_W_C0 = looking_along_x(p);
        mesher->update(*view, {});
    };
    fly_to({0.8, 0.8, 0.0}, 11);
    CHECK(mesher->mesh().face_count() == 2);
    fly_to({1.4, 0.8, 0.0}, 12);  // past it
    CHECK(mesher->mesh().face_count() == 2);
    fly_to({1.4, 0.2, 0.1}, 13);  // behind it
    CHECK(mesher->mesh().face_count() == 2);
    fly_to({0.6, 0.2, 0.1}, 14);  // through it
    CHECK(mesher->mesh().face_count() < 2);
    fly_to({1.4, -0.2, -0.1}, 15);
    CHECK(mesher->mesh().face_count() == 0);
}

TEST_CASE("two neighbours that leave at once leave one hole, which is closed") {
    World world;
    world.wall(1.2, 0.8, 0.25, [](double, double) { return 3.0; });
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, kHere, 10), {});
    const HorizonMesh& mesh = mesher->mesh();
    const double area = area_of(mesh);
    std::uint32_t middle = 0;
    for (const auto& [id, p] : world.points) {
        const Vector3d target(3.0, 0.0, 0.0);
        middle = (p - target).norm() < (world.points[middle].second - target).norm() ? id : middle;
    }
    std::uint32_t neighbour = middle;
    mesh.for_faces_of(mesh.find_vertex({middle}).value(), [&](FaceIndex f) {
        for (const VertexSlot v : mesh.face(f).vertex) {
            neighbour = mesh.landmark(v).value != middle ? mesh.landmark(v).value : neighbour;
        }
    });
    REQUIRE(neighbour != middle);
    auto view = view_of(world, kHere, 14, [=](std::uint32_t id) { return id != middle && id != neighbour; });
    forget_tracks(*view);
    view->T_W_C0 = looking_along_x({50.0, 0.0, 0.0});
    mesher->update(*view, {});
    CHECK(mesher->counters().holes_filled == 1);
    CHECK(area_of(mesh) == Approx(area).epsilon(1e-6));
    // A keyframe that shows a face that fills a hole makes it a face like others.
    view = view_of(world, kHere, 15, [=](std::uint32_t id) { return id != middle && id != neighbour; });
    mesher->update(*view, {});
    int fill = 0;
    for (int i = 0; i < mesh.face_end(); ++i) {
        const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
        fill += mesh.is_face(i) && face.is_fill && face.last_observed == 3 ? 1 : 0;
    }
    CHECK(fill == 0);
}

TEST_CASE("faces for which there is no vertex left are counted") {
    // GIVEN walls of surface points, one beside the other, whose keyframes all stay in the window
    const auto mesher = make_mesher();
    std::vector<KeyframePose> keyframes;
    for (int k = 0; k < kMaxKeyframes; ++k) {
        World wall;
        wall.next = static_cast<std::uint32_t>(1000 * k);
        wall.wall(1.4, 0.85, 0.18, [](double, double) { return 3.0; });
        for (auto& [id, p] : wall.points) {
            p.y() += 10.0 * k;
        }
        auto view = view_of(wall, looking_along_x({0.0, 10.0 * k, 0.0}), 10 + k);
        for (const LandmarkSnapshot& s : view->landmarks) {
            if (!view->surface.full()) {
                view->surface.push_back(s);
                view->surface.back().keyframes = 1;
                view->surface.back().first_stamp = view->stamp;
            }
        }
        view->landmarks.clear();
        view->oldest_stamp = {10'000'000'000LL};
        keyframes.push_back({view->stamp, view->T_W_C0});
        for (const KeyframePose& keyframe : keyframes) {
            view->keyframes.push_back(keyframe);
        }
        mesher->update(*view, {});
    }
    // THEN the store of vertices is full, and every accepted triangle is accounted for.
    REQUIRE(mesher->mesh().vertex_count() == kMaxMeshVertices);
    const MeshCounters& c = mesher->counters();
    CHECK(c.refused > 0);
    CHECK(c.verdicts[static_cast<std::size_t>(FaceVerdict::kAccepted)] == c.added + c.confirmed + c.refused);
}

TEST_CASE("a face that its landmarks turn inside out still looks to the side it was seen from") {
    World world = pane(2.0);
    const auto mesher = make_mesher();
    mesher->update(*view_of(world, kHere, 10), {});
    REQUIRE(mesher->mesh().face_count() == 2);
    // Seen from behind: the same faces, now to this side.
    const Se3 back{Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitZ())) * kHere.q,
                   Vector3d(4.0, 0.0, 0.0)};
    mesher->update(*view_of(world, back, 11), {});
    REQUIRE(mesher->mesh().face_count() == 2);
    for (int i = 0; i < 2; ++i) {
        const MeshFace& face = mesher->mesh().face(static_cast<FaceIndex>(i));
        CHECK(face.normal_W.x() == Approx(1.0F));
        CHECK(face.observations == 2);
        CHECK(face.contradictions == 0);
    }
    // Landmarks move so that the order of the corners turns round: left and right change places.
    for (auto& [id, p] : world.points) {
        p.y() = -p.y();
    }
    auto view = view_of(world, back, 12);
    forget_tracks(*view);
    mesher->update(*view, {});
    REQUIRE(mesher->mesh().face_count() == 2);
    for (int i = 0; i < 2; ++i) {
        CHECK(mesher->mesh().face(static_cast<FaceIndex>(i)).normal_W.x() == Approx(1.0F));
    }
}

TEST_CASE("while hovering, what is no longer seen in its place leaves; what is out of view stays") {
    // GIVEN a wall with a person in front of it, each seen once; the wall behind the person has no texture
    World wall;
    wall.wall(1.4, 0.8, 0.25, [](double, double) { return 4.0; });
    wall.points.erase(std::remove_if(wall.points.begin(), wall.points.end(),
                                     [](const auto& p) { return std::abs(p.second.y()) < 0.7; }),
                      wall.points.end());
    World person = wall;
    for (double y = -0.3; y <= 0.31; y += 0.2) {
        for (double z = -0.3; z <= 0.31; z += 0.2) {
            person.points.push_back({1000 + person.next++, {2.0, y, z}});
        }
    }
    const auto mesher = make_mesher();
    mesher->update(*view_of(person, kHere, 10), {});
    const auto near_faces = [&] {
        int count = 0;
        for (int i = 0; i < mesher->mesh().face_end(); ++i) {
            count += mesher->mesh().is_face(i) &&
                             mesher->mesh().centroid(mesher->mesh().face(static_cast<FaceIndex>(i))).x() < 2.5
                         ? 1
                         : 0;
        }
        return count;
    };
    REQUIRE(near_faces() > 10);
    // WHEN the person has left, but the window still holds the landmarks
    const auto hover = [&](int second, const Se3& T_W_C0) {
        auto view = view_of(person, kHere, second);
        for (LandmarkSnapshot& s : view->landmarks) {
            s.is_tracked = s.id.value < 1000 && T_W_C0.p.x() < 1.0;
            s.unseen_keyframes = s.is_tracked ? 0 : 10;
        }
        view->T_W_C0 = T_W_C0;
        mesher->update(*view, {});
    };
    // THEN nothing happens out of view,
    const Se3 away = looking_along_x({50.0, 0.0, 0.0});
    for (int k = 11; k < 30; ++k) {
        hover(k, away);
    }
    CHECK(near_faces() > 10);
    // AND the faces leave within max_unseen_s in view.
    for (int k = 30; k < 37; ++k) {
        hover(k, kHere);
    }
    CHECK(near_faces() == 0);
    CHECK(mesher->counters().judged_bad == 0);
}

}  // namespace
}  // namespace facet::mesh_evidence_test
