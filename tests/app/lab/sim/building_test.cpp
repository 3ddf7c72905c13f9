// SPDX-License-Identifier: BSD-2-Clause
// Buildings of many seeds: rooms apart and joined by free passages, walls of any azimuth, floors of any tilt.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "app/lab/sim/building_plan.h"
#include "app/lab/sim/flight.h"
#include "app/lab/sim/truth.h"
#include "app/support/rng.h"
#include "platform/base/angle.h"

namespace facet::sim::building_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr SceneDetail kQuick{16, 2.0, 4, 1};

/// Whether a place in the world lies within a room's walls.
bool is_inside(const RoomPlan& room, const Vector2d& p) {
    for (int wall = 0; wall < 4; ++wall) {
        const Vector2d corner = room.to_world(room.corners[static_cast<std::size_t>(wall)]);
        const Vector2d outwards = Eigen::Rotation2Dd(room.yaw_rad) * room.wall_normal(wall);
        if ((p - corner).dot(outwards) > 0.0) {
            return false;
        }
    }
    return true;
}

TEST_CASE("Rooms of a building do not overlap, and each is behind a passage of an earlier one") {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        INFO("seed " << seed);
        const BuildingPlan plan = draw_building(seed);
        REQUIRE(plan.rooms.size() >= 3);
        REQUIRE(plan.passages.size() == plan.rooms.size() - 1);
        RandomStream random(seed, 3);
        for (const RoomPlan& room : plan.rooms) {
            for (int k = 0; k < 200; ++k) {
                const double x = random.uniform(-1.0, 1.0);
                const Vector2d p = room.to_world(room.half.cwiseProduct(Vector2d(x, random.uniform(-1.0, 1.0))));
                int owners = 0;
                for (const RoomPlan& other : plan.rooms) {
                    owners += is_inside(other, p) ? 1 : 0;
                }
                CHECK(owners <= 1);
            }
        }
        for (std::size_t i = 0; i < plan.passages.size(); ++i) {
            const Passage& p = plan.passages[i];
            REQUIRE(p.to == static_cast<int>(i) + 1);
            REQUIRE(p.from < p.to);
            const double length = 0.5 * (p.left_m + p.right_m);
            CHECK(is_inside(plan.rooms[static_cast<std::size_t>(p.from)], p.start - 0.1 * p.direction));
            CHECK(is_inside(plan.rooms[static_cast<std::size_t>(p.to)], p.start + (length + 0.1) * p.direction));
        }
    }
}

TEST_CASE("A passage is level with the floors at both its ends") {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        INFO("seed " << seed);
        const BuildingPlan plan = draw_building(seed);
        for (const RoomPlan& room : plan.rooms) {
            for (const Doorway& d : room.doorways) {
                CHECK(d.sill_z - room.floor_at(room.on_wall(d.wall, d.along_m)) == Approx(0.01));
            }
        }
    }
}

TEST_CASE("Buildings differ: floors from level to 3 degrees, walls of any azimuth, climbs and pitched ceilings") {
    double steepest = 0.0;
    double most_level = 1.0;
    std::set<int> azimuths;  // of walls against the first room's, in bins of 5 degrees of a quarter turn
    std::set<FloorKind> floors;
    std::set<CeilingKind> ceilings;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const BuildingPlan plan = draw_building(seed);
        for (const RoomPlan& room : plan.rooms) {
            floors.insert(room.floor);
            ceilings.insert(room.ceiling);
            if (!room.is_climb()) {
                steepest = std::max(steepest, room.slope.norm());
                most_level = std::min(most_level, room.slope.norm());
            }
            for (int wall = 0; wall < 4; ++wall) {
                const Vector2d n = room.wall_normal(wall);
                const double turn = room.yaw_rad - plan.rooms.front().yaw_rad + std::atan2(n.y(), n.x());
                azimuths.insert(static_cast<int>(std::floor((turn / kRadPerDeg + 3600.0) / 5.0)) % 18);
            }
        }
    }
    CHECK(steepest > std::tan(2.0 * kRadPerDeg));
    CHECK(steepest <= std::tan(3.0 * kRadPerDeg) + 1e-9);
    CHECK(most_level < std::tan(0.05 * kRadPerDeg));
    CHECK(azimuths.size() >= 15);
    CHECK(floors.size() == 3);
    CHECK(ceilings.size() == 3);
}

TEST_CASE("The way through every passage is free, and walls are closed around it") {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
        INFO("seed " << seed);
        const Scene scene = make_building(kQuick, seed);
        const auto& gates = scene.flight_volume().gates;
        REQUIRE(gates.size() >= 4);
        RandomStream random(seed, 4);
        for (std::size_t i = 0; i + 1 < gates.size(); i += 2) {
            for (int k = 0; k <= 20; ++k) {
                const Vector3d p = gates[i] + 0.05 * k * (gates[i + 1] - gates[i]);
                CHECK(scene.clearance(p, 1.0) > scene.flight_volume().clearance_m);
                for (int ray = 0; ray < 20; ++ray) {
                    const Vector3d d = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
                    CHECK(scene.cast(p, d).surface >= 0);
                }
            }
        }
    }
}

TEST_CASE("Flights through buildings keep clearance and go from room to room") {
    int doors = 0;
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
        INFO("seed " << seed);
        const Scene scene = make_building(kQuick, seed);
        FlightPlan plan;
        plan.seed = seed;
        Flight flight;
        REQUIRE(ok(plan_flight(scene, plan, flight)));
        const FlightReport report = inspect_flight(flight, scene);
        CHECK(report.min_clearance_m >= scene.flight_volume().clearance_m);
        CHECK(report.path_m > 10.0);
        const BuildingPlan building = draw_building(seed);
        int last = -1;
        for (double t = 0.0; t < flight.duration_s(); t += 0.1) {
            const Vector2d p = flight.evaluate(t).T_W_B.p.head<2>();
            for (int room = 0; room < static_cast<int>(building.rooms.size()); ++room) {
                if (is_inside(building.rooms[static_cast<std::size_t>(room)], p) && room != last) {
                    doors += last >= 0 ? 1 : 0;
                    last = room;
                }
            }
        }
    }
    CHECK(doors >= 6);
}

TEST_CASE("Relief and pictures belong to their wall's plane, and planes face the room") {
    const Scene scene = make_building(kQuick, 3);
    const std::vector<TruePlane> planes = true_planes(scene, {});
    int walls = 0;
    for (const TruePlane& p : planes) {
        walls += p.name == "wall" ? 1 : 0;
        CHECK(p.name != "relief");
        CHECK(p.name != "picture");
    }
    CHECK(walls >= 12);
    const Vector3d inside = scene.flight_volume().start;
    const RayHit below = scene.cast(inside, -Vector3d::UnitZ());
    CHECK(surface_normal(scene.shapes()[static_cast<std::size_t>(below.surface)], 0.5, 0.5).z() > 0.9);
}

}  // namespace
}  // namespace facet::sim::building_test
