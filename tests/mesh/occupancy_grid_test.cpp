// SPDX-License-Identifier: BSD-2-Clause
// The grid on made-up keyframes: free is what was seen through or flown through, occupied what the mesh shows, and all
// else is unknown.
#include "mesh/occupancy_grid.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "tests/mesh/grid_watcher.h"

namespace facet::occupancy_grid_test {
namespace {

using Eigen::Vector3d;
using test::looking_along_x;
using test::make_mesher;
using test::view_of;
using test::wall_at;
using Watcher = test::GridWatcher;
using World = test::MeshWorld;

const Se3 kHere = looking_along_x({0.03, 0.03, 0.03});
const Vector3d kEye = kHere.p;

TEST_CASE("before a wall is free, the wall is occupied, what lies behind or aside is unknown") {
    Watcher w;
    CHECK(w.grid->at(kEye).space == Space::kUnknown);
    for (int k = 0; k < 4; ++k) {
        w.see(wall_at(3.05), kHere, 10.0 + 0.25 * k);
    }
    CHECK(w.grid->at({1.5, 0.0, 0.0}).space == Space::kFree);
    CHECK(w.grid->at({1.5, 0.0, 0.0}).certainty > 0.75F);
    CHECK(w.grid->at({3.02, 0.0, 0.0}).space == Space::kOccupied);
    CHECK(w.grid->at({3.5, 0.0, 0.0}).space == Space::kUnknown);
    CHECK(w.grid->at({1.5, 3.0, 0.0}).space == Space::kUnknown);
    CHECK(w.grid->at({50.0, 0.0, 0.0}).space == Space::kUnknown);
    const GridRay ahead = w.grid->cast(kEye, Vector3d::UnitX(), 6.0);
    CHECK(ahead.end.space == Space::kOccupied);
    CHECK(ahead.free_m == Approx(2.97).margin(0.11));
    CHECK(ahead.obstacle_m == ahead.free_m);
    const GridRay aside = w.grid->cast(kEye, Vector3d::UnitY(), 6.0);
    CHECK(aside.end.space == Space::kUnknown);
    CHECK(aside.free_m < 0.5);  // the body's own place
    CHECK(std::isinf(aside.obstacle_m));
    const GridRay part = w.grid->cast(kEye, Vector3d::UnitX(), 2.0);
    CHECK(part.end.space == Space::kFree);
    CHECK(part.free_m == 2.0);
}

TEST_CASE("a ray passes a wall closely, but not what is in the wall; a vehicle there does not") {
    Watcher w;
    for (int k = 0; k < 4; ++k) {
        w.see(wall_at(3.06), kHere, 10.0 + 0.25 * k);
    }
    // Along the wall, in the cells that it occupies: 5 cm before it, and in it.
    const Vector3d before(3.01, -0.8, 0.03);
    const GridRay along = w.grid->cast(before, Vector3d::UnitY(), 1.6);
    CHECK(along.end.space == Space::kFree);
    CHECK(along.free_m == 1.6);
    CHECK(std::isinf(along.obstacle_m));
    CHECK(w.grid->cast(before + Vector3d(0.055, 0.0, 0.0), Vector3d::UnitY(), 1.6).obstacle_m < 0.05);
    CHECK(w.grid->cast(kEye, Vector3d::UnitX(), 6.0).obstacle_m == Approx(3.03).margin(0.026));
    CHECK(w.grid->at(before).space == Space::kOccupied);
    CHECK(w.grid->segment(before, before + Vector3d(0.0, 1.6, 0.0), 0.0).space == Space::kOccupied);
    CHECK(w.grid->nearest(before, 1.0).obstacle_m < 1e-9);
}

TEST_CASE("where lines of sight pass an occupied cell, its surface is no more") {
    Watcher w;
    GridConfig coarse;
    coarse.cell_m = 0.5;  // parts of 12.5 cm
    REQUIRE(ok(w.grid->configure(coarse)));
    for (int k = 0; k < 4; ++k) {
        w.see(wall_at(3.05), kHere, 10.0 + 0.25 * k);
    }
    CHECK(w.grid->cast(kEye, Vector3d::UnitX(), 6.0).obstacle_m == Approx(2.97).margin(1e-6));
    // The same landmarks turn out to be farther, in the same cell.
    for (int k = 4; k < 8; ++k) {
        w.see(wall_at(3.45), kHere, 10.0 + 0.25 * k);
    }
    CHECK(w.grid->cast(kEye, Vector3d::UnitX(), 6.0).obstacle_m == Approx(3.345).margin(1e-6));
    CHECK(w.grid->at({3.05, 0.0, 0.0}).space == Space::kOccupied);
}

TEST_CASE("a blank wall is unknown, not free, in the ray and in the sweep") {
    // GIVEN landmarks at two borders of a wall too far apart for a face: nothing between them
    World borders = wall_at(3.05);
    borders.points.erase(std::remove_if(borders.points.begin(), borders.points.end(),
                                        [](const auto& p) { return std::abs(p.second.y()) < 0.9; }),
                         borders.points.end());
    MeshConfig config;
    config.faces.max_side_m = config.faces.max_flat_side_m = 0.6;
    Watcher w;
    w.mesher = make_mesher(config);
    for (int k = 0; k < 6; ++k) {
        w.see(borders, kHere, 10.0 + 0.25 * k);
    }
    CHECK(w.grid->cast(kEye, Vector3d::UnitX(), 5.0).end.space == Space::kUnknown);
    std::array<GridSector, kSweepSectors> sectors;
    w.grid->sweep({.p_W = kEye, .start_rad = -0.5 * 2.0 * std::numbers::pi / kSweepSectors, .max_range_m = 5.0},
                  sectors);
    CHECK(sectors[0].state.space == Space::kUnknown);
    CHECK(sectors[0].free_m < 1.0F);
    CHECK(std::isinf(sectors[0].obstacle_m));
    CHECK(sectors[4].state.space == Space::kOccupied);  // 20 degrees aside
    CHECK(sectors[36].state.space == Space::kUnknown);
}

TEST_CASE("a sweep finds a wall and, once it was seen through, tells free space from unknown") {
    Watcher w;
    for (int k = 0; k < 4; ++k) {
        w.see(wall_at(5.05), kHere, 10.0 + 0.25 * k);
    }
    std::array<GridSector, kSweepSectors> sectors;
    const double start = -std::numbers::pi / kSweepSectors;
    w.grid->sweep({.p_W = kEye, .start_rad = start, .max_range_m = 6.0}, sectors);
    CHECK(sectors[0].state.space == Space::kOccupied);
    CHECK(sectors[0].obstacle_m == Approx(4.97F).margin(0.11));
    CHECK(sectors[0].free_m == Approx(sectors[0].obstacle_m).margin(0.11));
    CHECK(sectors[0].state.certainty > 0.7F);
    CHECK(sectors[0].state.age_s == 0.0F);
    w.grid->sweep({.p_W = kEye, .start_rad = start, .max_range_m = 3.0}, sectors);
    CHECK(sectors[0].state.space == Space::kFree);
    CHECK(sectors[0].free_m == 3.0F);
    CHECK(sectors[18].state.space == Space::kUnknown);
}

TEST_CASE("what moves fades within two seconds of being seen through, and is seen at once when it comes") {
    World person;
    for (double y = -0.25; y <= 0.26; y += 0.125) {
        for (double z = -0.5; z <= 0.51; z += 0.125) {
            person.points.push_back({5000 + person.next++, {2.05, y + 0.01 * z, z + 0.01 * y}});
        }
    }
    World both = wall_at(4.05);
    std::erase_if(both.points, [](const auto& p) { return std::abs(p.second.y()) < 0.6; });
    both.points.insert(both.points.end(), person.points.begin(), person.points.end());
    Watcher w;
    double t = 10.0;
    for (int k = 0; k < 8; ++k, t += 0.25) {
        w.see(wall_at(4.05), kHere, t);
    }
    REQUIRE(w.grid->at({2.0, 0.0, 0.0}).space == Space::kFree);
    w.see(both, kHere, t);
    CHECK(w.grid->at({2.02, 0.02, 0.02}).space == Space::kOccupied);
    for (int k = 0; k < 8; ++k, t += 0.25) {
        w.see(both, kHere, t);
    }
    const double gone = t;
    while (w.grid->cast(kEye, Vector3d::UnitX(), 3.0).end.space != Space::kFree && t < gone + 5.0) {
        w.see(wall_at(4.05), kHere, t);
        t += 0.25;
    }
    CHECK(t - gone <= 2.0);
}

TEST_CASE("the body carves where it has flown, also through what the mesh holds for a wall") {
    Watcher w;
    w.see(wall_at(1.05), kHere, 10.0);
    REQUIRE(w.grid->at({1.02, 0.02, 0.02}).space == Space::kOccupied);
    w.see({}, looking_along_x({0.6, 0.0, 0.0}), 10.5);
    w.see({}, looking_along_x({1.6, 0.0, 0.0}), 11.0);
    CHECK(w.grid->at({1.02, 0.02, 0.02}).space == Space::kFree);
    CHECK(w.grid->segment({0.0, 0.0, 0.0}, {1.6, 0.0, 0.0}, 0.1).space == Space::kFree);
    CHECK(w.grid->segment({0.0, 0.0, 0.0}, {1.6, 0.0, 0.0}, 0.6).space == Space::kOccupied);
    CHECK(w.grid->segment({1.6, 0.0, 0.0}, {3.0, 0.0, 0.0}, 0.1).space == Space::kUnknown);
    CHECK(w.grid->box({1.4, -0.1, -0.1}, {1.6, 0.1, 0.1}).space == Space::kFree);
    CHECK(w.grid->box({0.9, 0.4, -0.1}, {1.1, 0.6, 0.1}).space == Space::kOccupied);
    CHECK(w.grid->box({20.0, 0.4, -0.1}, {21.1, 0.6, 0.1}).space == Space::kUnknown);
}

TEST_CASE("a face in whose place the keyframe sees a step is no obstacle") {
    // GIVEN a wall some points of which turn out to be a metre and a half farther away: faces span the step
    World flat = wall_at(3.05);
    World stepped = flat;
    for (auto& [id, p] : stepped.points) {
        p *= id % 7 == 0 ? 1.5 : 1.0;  // along the ray: the triangles in the image stay the same
    }
    Watcher w;
    w.see(flat, kHere, 10.0);
    w.see(stepped, kHere, 10.25);
    int bridging = 0;
    for (int i = 0; i < w.mesher->mesh().face_end(); ++i) {
        if (w.mesher->mesh().is_face(i)) {
            const MeshFace& face = w.mesher->mesh().face(static_cast<FaceIndex>(i));
            const double x = w.mesher->mesh().centroid(face).x();
            bridging += x > 3.4 && x < 4.2 ? 1 : 0;
        }
    }
    REQUIRE(bridging > 3);  // one contradiction does not remove a face
    int occupied = 0;
    for (double z = -0.95; z < 1.0; z += 0.1) {
        for (double y = -1.45; y < 1.5; y += 0.1) {
            for (double x = 3.35; x < 4.3; x += 0.1) {
                occupied += w.grid->at({x, y, z}).space == Space::kOccupied ? 1 : 0;
            }
        }
    }
    CHECK(occupied == 0);
}

/// A mesh of one face across the x axis at 3 m.
std::unique_ptr<HorizonMesh> one_face(double sigma_m) {
    auto mesh = std::make_unique<HorizonMesh>();
    std::array<VertexSlot, 3> slots{};
    const std::array<Vector3d, 3> corners{Vector3d(3.05, -0.6, -0.4), Vector3d(3.05, 0.0, 0.7),
                                          Vector3d(3.05, 0.6, -0.4)};
    for (std::uint32_t k = 0; k < 3; ++k) {
        slots[k] = mesh->add_vertex({k + 1}).value();
        mesh->vertex(slots[k]).measured_W = corners[k];
        mesh->vertex(slots[k]).covariance_W = static_cast<float>(sigma_m * sigma_m) * Eigen::Matrix3f::Identity();
    }
    MeshFace& face = mesh->face(mesh->add_face(slots).value());
    face.observations = 3;
    face.last_observed = 1;
    return mesh;
}

TEST_CASE("a face that only closes a hole neither makes an obstacle nor frees what is before it") {
    const auto mesh = one_face(0.01);
    MeshFace& face = mesh->face(0);
    face.is_fill = true;
    const auto view = view_of({}, kHere, 10);
    const auto owned = std::make_unique<OccupancyGrid>();
    OccupancyGrid& grid = *owned;
    grid.update(*view, *mesh, 1);
    CHECK(grid.at({3.02, 0.0, 0.0}).space == Space::kUnknown);
    grid.update(*view, *mesh, 1);
    CHECK(grid.at({1.5, 0.0, 0.0}).space == Space::kUnknown);
    // WHEN a keyframe shows it
    face.is_fill = false;
    face.last_confirmed = 1;
    grid.update(*view, *mesh, 1);
    CHECK(grid.at({3.02, 0.0, 0.0}).space == Space::kOccupied);
}

TEST_CASE("a face frees what is before it when a second keyframe has confirmed it") {
    const auto mesh = one_face(0.01);
    MeshFace& face = mesh->face(0);
    face.last_confirmed = 1;
    face.observations = 1;
    const auto view = view_of({}, kHere, 10);
    const auto grid = std::make_unique<OccupancyGrid>();
    const auto watch = [&] {
        for (int k = 0; k < 4; ++k) {
            view->stamp = view->stamp + Duration::from_seconds(0.25);
            grid->update(*view, *mesh, 1);
        }
    };
    watch();
    CHECK(grid->at({1.5, 0.0, 0.0}).space == Space::kUnknown);
    CHECK(grid->at({3.02, 0.0, 0.0}).space == Space::kOccupied);  // an obstacle it is at once
    face.observations = 2;
    watch();
    CHECK(grid->at({1.5, 0.0, 0.0}).space == Space::kFree);
}

TEST_CASE("a face seen at a grazing angle leaves its place unknown: it may bridge a step") {
    const auto mesh = one_face(0.01);
    MeshFace& face = mesh->face(0);
    const auto view = view_of({}, kHere, 10);
    const auto grid = std::make_unique<OccupancyGrid>();
    const auto turned_to = [&](double deg) {
        const double angle = deg * std::numbers::pi / 180.0;
        face.normal_W = Vector3d(-std::cos(angle), 0.0, std::sin(angle)).cast<float>();
        face.last_confirmed = 1;
        grid->clear();
        grid->update(*view, *mesh, 1);
        return grid->at({3.02, 0.0, 0.0}).space;
    };
    CHECK(turned_to(0.0) == Space::kOccupied);
    CHECK(turned_to(60.0) == Space::kOccupied);
    CHECK(turned_to(70.0) == Space::kUnknown);
}

TEST_CASE("a ray is ended by the parts that the depth points of two keyframes are in, not by their whole cells") {
    const auto grid = std::make_unique<OccupancyGrid>();
    const auto view = std::make_unique<KeyframeView>();
    const HorizonMesh nothing;
    view->T_W_C0 = kHere;
    std::vector<Vector3d> seen;
    for (int k = 0; k < 2; ++k) {
        // GIVEN points on a wall, 10 cm apart, elsewhere on it at each keyframe
        std::vector<DepthPoint> points;
        for (int i = -6; i <= 6; ++i) {
            for (int j = -4; j <= 4; ++j) {
                points.push_back({{3.06, 0.1 * i + 0.03 + 0.04 * k, 0.1 * j + 0.03}, 0.01});
                seen.push_back(points.back().p_W);
            }
        }
        view->stamp = Timestamp{} + Duration::from_seconds(10.0 + 0.25 * k);
        grid->update(*view, nothing, static_cast<std::uint32_t>(k + 1));
        CHECK(std::isinf(grid->cast(kEye, Vector3d::UnitX(), 6.0).obstacle_m));
        grid->add_depth({points.data(), points.size()});
    }
    // THEN a ray to a point of either ends within a part's diagonal of it
    for (const Vector3d& p : seen) {
        const Vector3d ray = p - kEye;
        const double obstacle_m = grid->cast(kEye, ray, 6.0).obstacle_m;
        CHECK(obstacle_m == Approx(ray.norm()).margin(0.045));
        CHECK(grid->has_surface(p));
    }
    // THEN one along the wall passes 5 cm before it, in the same cells
    const Vector3d before(3.01, -0.55, 0.03);
    CHECK(std::isinf(grid->cast(before, Vector3d::UnitY(), 1.1).obstacle_m));
    CHECK(grid->at(before).space == Space::kOccupied);
    CHECK(!grid->has_surface(before));
    // THEN one between the points is not told that there is nothing behind
    const GridRay between = grid->cast(kEye, Vector3d(3.06, 0.305, 0.405) - kEye, 6.0);
    CHECK(between.end.space != Space::kFree);
    CHECK(between.free_m < 3.06 + 0.2);
}

TEST_CASE("nearest cells agree with a search over all of them") {
    Watcher w;
    World world;
    world.wall(1.6, 1.0, 0.2, [](double y, double z) { return 2.5 + 0.5 * y + 0.3 * z; });
    for (int k = 0; k < 4; ++k) {
        w.see(world, kHere, 10.0 + 0.25 * k);
    }
    const double size = w.grid->cell_m();
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (int trial = 0; trial < 12; ++trial) {
        const Vector3d p(1.0 + uniform(random), uniform(random), 0.7 * uniform(random));
        const Vector3d axis = Vector3d(1.0, 0.5 * uniform(random), 0.3 * uniform(random)).normalized();
        const double half = 0.3;
        std::array<double, 2> obstacle{2.5, 2.5};
        std::array<double, 2> unknown{2.5, 2.5};
        for (int x = -20; x < 60; ++x) {
            for (int y = -40; y < 40; ++y) {
                for (int z = -35; z < 35; ++z) {
                    const Vector3d centre = size * Vector3d(x + 0.5, y + 0.5, z + 0.5);
                    const double d = ((p - centre).cwiseAbs().array() - 0.5 * size).max(0.0).matrix().norm();
                    const Space space = w.grid->at(centre).space;
                    const bool in_cone = axis.dot(centre - p) >= std::cos(half) * (centre - p).norm();
                    for (std::size_t k = 0; k < 2; ++k) {
                        if (k == 0 || in_cone) {
                            obstacle[k] = space == Space::kOccupied ? std::min(obstacle[k], d) : obstacle[k];
                            unknown[k] = space == Space::kUnknown ? std::min(unknown[k], d) : unknown[k];
                        }
                    }
                }
            }
        }
        const std::array<GridNearest, 2> found{w.grid->nearest(p, 2.5),
                                               w.grid->nearest_in_direction(p, axis, half, 2.5)};
        for (std::size_t k = 0; k < 2; ++k) {
            INFO(trial << " " << k);
            CHECK(std::min(2.5, found[k].obstacle_m) == Approx(obstacle[k]));
            // The search ends with the obstacle: what is unknown is complete up to there.
            if (unknown[k] <= obstacle[k]) {
                CHECK(std::min(2.5, found[k].unknown_m) == Approx(unknown[k]));
            }
        }
    }
}

TEST_CASE("the grid rolls with the vehicle and forgets what leaves it, ages, and forgets in time") {
    Watcher w;
    for (int k = 0; k < 4; ++k) {
        w.see(wall_at(3.05), kHere, 10.0 + 0.25 * k);
    }
    // 5 m on, the wall is still there; 20 m on and back, it is not.
    w.see({}, looking_along_x({-5.0 + 3.0, 0.0, 0.0}), 15.0);
    CHECK(w.grid->at({3.02, 0.0, 0.0}).space == Space::kOccupied);
    CHECK(w.grid->at({3.02, 0.0, 0.0}).age_s == Approx(4.25F).margin(0.07));
    w.see({}, looking_along_x({-20.0, 0.0, 0.0}), 16.0);
    w.see({}, kHere, 17.0);
    CHECK(w.grid->at({3.02, 0.0, 0.0}).space == Space::kUnknown);
    CHECK(w.grid->at({1.5, 0.0, 0.0}).space == Space::kUnknown);
    CHECK(w.grid->at(kEye).space == Space::kFree);
    const std::array<int, 3> count = w.grid->count();
    CHECK(count[0] + count[1] + count[2] == OccupancyGrid::kGridX * OccupancyGrid::kGridY * OccupancyGrid::kGridZ);
    GridConfig config;
    REQUIRE(ok(w.grid->configure(config)));
    for (int k = 0; k < 4; ++k) {
        w.see(wall_at(3.05), kHere, 20.0 + 0.25 * k);
    }
    REQUIRE(w.grid->at({3.02, 0.0, 0.0}).space == Space::kOccupied);
    for (int k = 0; k < 80; ++k) {
        w.see({}, kHere, 21.0 + 10.0 * k);
    }
    CHECK(w.grid->at({3.02, 0.0, 0.0}).space == Space::kUnknown);
    config.cell_m = 0.0;
    CHECK(w.grid->configure(config) == Status::kInvalidArgument);
}

TEST_CASE("two grids with the same keyframes give the same answers") {
    Watcher a;
    Watcher b;
    for (int k = 0; k < 5; ++k) {
        a.see(wall_at(3.05), kHere, 10.0 + 0.25 * k);
        b.see(wall_at(3.05), kHere, 10.0 + 0.25 * k);
    }
    CHECK(a.grid->count() == b.grid->count());
}

}  // namespace
}  // namespace facet::occupancy_grid_test
