// SPDX-License-Identifier: BSD-2-Clause
// Scene "building": rooms, corridors, ramps and stairs of a plan drawn from the seed, with doors to fly through.
#include <Eigen/Geometry>
#include <algorithm>

#include "app/lab/sim/building_parts.h"
#include "app/lab/sim/scene.h"

namespace facet::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kEye_m = 1.25;         // of flights above floors
constexpr double kBeforeDoor_m = 0.65;  // of gates from their doorway

/// Either side of each passage: from one to the other a flight goes straight through.
std::vector<Vector3d> gates_of(const BuildingPlan& plan) {
    std::vector<Vector3d> gates;
    for (const Passage& p : plan.passages) {
        const double length = 0.5 * (p.left_m + p.right_m);
        for (const double along : {-kBeforeDoor_m, length + kBeforeDoor_m}) {
            const Vector2d at = p.start + along * p.direction;
            gates.emplace_back(at.x(), at.y(), p.floor_z + kEye_m - 0.2);
        }
    }
    return gates;
}

FlightVolume volume_of(const BuildingPlan& plan) {
    FlightVolume volume;
    volume.low = Vector3d::Constant(1e9);
    volume.high = Vector3d::Constant(-1e9);
    for (const RoomPlan& room : plan.rooms) {
        for (const Vector2d& corner : room.corners) {
            const Vector2d p = room.to_world(corner);
            volume.low = volume.low.cwiseMin(Vector3d(p.x(), p.y(), room.lowest_floor() + 0.7));
            volume.high = volume.high.cwiseMax(Vector3d(p.x(), p.y(), room.highest_floor() + 2.1));
        }
    }
    const RoomPlan& first = plan.rooms.front();
    volume.start = {first.centre.x(), first.centre.y(), first.floor_z + kEye_m};
    volume.start_yaw_rad = first.yaw_rad;
    volume.clearance_m = 0.35;
    volume.reach_m = 5.0;
    volume.gates = gates_of(plan);
    return volume;
}

}  // namespace

Scene make_building(const SceneDetail& detail, std::uint64_t seed) {
    const BuildingPlan plan = draw_building(seed);
    RandomStream random(seed, 62);
    SceneBuilder b("building");
    const BuildingMaterials materials = make_building_materials(b, plan.richness, random);
    for (const RoomPlan& room : plan.rooms) {
        RoomSite site{b, materials, plan, room, random};
        add_shell(site);
        add_furnishing(site);
    }
    for (const Passage& passage : plan.passages) {
        add_passage(b, materials, passage);
    }
    b.ambient(0.4);
    b.flight_volume(volume_of(plan));
    return b.build(detail);
}

}  // namespace facet::sim
