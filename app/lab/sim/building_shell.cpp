// SPDX-License-Identifier: BSD-2-Clause
// The shell of a building's rooms, and the passages between them.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "app/lab/sim/building_parts.h"

namespace facet::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBelow_m = 0.1;    // walls reach so far below the lowest floor,
constexpr double kAbove_m = 0.1;    // above the highest ceiling,
constexpr double kBeyond_m = 0.06;  // and beyond the corners: where walls lean no gap opens
constexpr double kFrame_m = 0.04;   // by which the sides of a passage stand out of the walls
constexpr double kStep_m = 0.17;    // rise of a stair
constexpr double kLampDrop_m = 0.03;
constexpr double kLampSpacing_m = 3.2;
constexpr double kLampPower = 2.2;

double ceiling_base(const RoomPlan& room) { return room.highest_floor() + room.height_m; }

double ceiling_top(const RoomPlan& room) {
    const double depth = room.ceiling == CeilingKind::kFlat    ? 0.0
                         : room.ceiling == CeilingKind::kGable ? room.half.y()
                                                               : 2.0 * room.half.y();
    return ceiling_base(room) + depth * room.pitch;
}

Vector3d at_height(const Vector2d& p, double z) { return {p.x(), p.y(), z}; }

/// A rectangle over the stretch [x0, x1] of a room's frame, over its whole width, from height z0 to z1.
void add_floor_strip(RoomSite& site, const char* name, MaterialId m, double x0, double x1, double z0, double z1) {
    const RoomPlan& room = site.room;
    const Vector3d a = at_height(room.to_world({x0, -room.half.y()}), z0);
    site.builder.rectangle(name, m, a, at_height(room.to_world({x1, -room.half.y()}), z1) - a,
                           at_height(room.to_world({x0, room.half.y()}), z0) - a);
}

void add_stairs(RoomSite& site, MaterialId m, double x0, double x1) {
    const RoomPlan& room = site.room;
    const int steps = std::max(2, static_cast<int>(std::lround(std::abs(room.climb_m) / kStep_m)));
    const double rise = room.climb_m / steps;
    const double run = (x1 - x0) / (steps - 1);
    for (int i = 0; i < steps; ++i) {
        const double x = x0 + run * i;
        const double z = room.floor_z + rise * i;
        const Vector3d foot = at_height(room.to_world({x, -room.half.y()}), z);
        const Vector3d across = at_height(room.to_world({x, room.half.y()}), z) - foot;
        const Vector3d up = Vector3d(0, 0, rise);
        // A riser faces whoever comes up to it.
        site.builder.rectangle("stairs.riser", site.materials.wood, rise > 0 ? Vector3d(foot + across) : foot,
                               rise > 0 ? Vector3d(-across) : across, up);
        if (i + 1 < steps) {
            add_floor_strip(site, "stairs.tread", m, x, x + run, z + rise, z + rise);
        }
    }
}

void add_floor(RoomSite& site) {
    const RoomPlan& room = site.room;
    const MaterialId m = site.materials.floors[static_cast<std::size_t>(site.random.index(3))];
    const double x = room.half.x();
    if (room.is_climb()) {
        const double x0 = -x + RoomPlan::kLanding_m;
        add_floor_strip(site, "floor", m, -x, x0, room.floor_z, room.floor_z);
        add_floor_strip(site, "floor", m, -x0, x, room.floor_z + room.climb_m, room.floor_z + room.climb_m);
        if (room.floor == FloorKind::kStairs) {
            add_stairs(site, m, x0, -x0);
        } else {
            add_floor_strip(site, "ramp", m, x0, -x0, room.floor_z, room.floor_z + room.climb_m);
        }
        return;
    }
    // The edges of a tilted floor: one along x, the other at a right angle to it in the plane.
    const Vector3d normal = Vector3d(-room.slope.x(), -room.slope.y(), 1.0).normalized();
    const Eigen::AngleAxisd turn(room.yaw_rad, Vector3d::UnitZ());
    const Vector3d u = turn * Vector3d(1.0, 0.0, room.slope.x()).normalized();
    const Vector3d v = (turn * normal).cross(u);
    const Vector2d reach = 1.01 * room.half + Vector2d::Constant(0.02);
    const Vector3d middle = at_height(room.centre, room.floor_z);
    site.builder.rectangle("floor", m, middle - reach.x() * u - reach.y() * v, 2.0 * reach.x() * u,
                           2.0 * reach.y() * v);
}

void add_ceiling(RoomSite& site) {
    const RoomPlan& room = site.room;
    const MaterialId m = site.materials.ceilings[static_cast<std::size_t>(site.random.index(3))];
    const Vector2d half = room.half + Vector2d::Constant(0.02);
    const auto strip = [&](double y0, double z0, double y1, double z1) {
        const Vector3d a = at_height(room.to_world({-half.x(), y1}), z1);
        site.builder.rectangle("ceiling", m, a, at_height(room.to_world({half.x(), y1}), z1) - a,
                               at_height(room.to_world({-half.x(), y0}), z0) - a);
    };
    const double low = ceiling_base(room);
    const double high = ceiling_top(room);
    if (room.ceiling == CeilingKind::kGable) {
        strip(-half.y(), low, 0.0, high);
        strip(0.0, high, half.y(), low);
    } else {
        strip(-half.y(), low, half.y(), high);
    }
}

/// One wall: pieces between and above its doorways, all in one plane.
void add_wall(RoomSite& site, int wall) {
    const RoomPlan& room = site.room;
    const double length = room.wall_length(wall);
    const Eigen::Rotation2Dd turn(room.yaw_rad);
    const Vector2d along = turn * room.wall_direction(wall);
    const Vector2d outwards = turn * room.wall_normal(wall);
    const double lean = std::tan(room.wall_lean_rad[static_cast<std::size_t>(wall)]);
    const double bottom = room.lowest_floor() - kBelow_m;
    const double top = ceiling_top(room) + kAbove_m;
    const bool is_bare = site.random.uniform() < 0.1 + 0.6 * (1.0 - site.building.richness);
    const MaterialId m = site.materials.walls[is_bare ? 0 : static_cast<std::size_t>(1 + site.random.index(5))];
    const auto point = [&](double s, double z) {
        const double out = lean * (z - bottom);
        return at_height(room.to_world(room.on_wall(wall, s)) + out * outwards, z);
    };
    const auto piece = [&](double s0, double s1, double z0, double z1) {
        if (s1 - s0 < 1e-3 || z1 - z0 < 1e-3) {
            return;
        }
        const Vector3d a = point(s1, z0);
        site.builder.rectangle("wall", m, a, at_height((s0 - s1) * along, 0.0), point(s1, z1) - a);
        // Relief of up to a centimetre, as of panels and rough plaster.
        const bool is_rough = site.building.richness > 0.2 && s1 - s0 > 1.0 && site.random.uniform() < 0.25;
        for (double s = s0 + 0.1; is_rough && s + 0.6 < s1; s += 0.7) {
            for (double z = z0 + 0.4; z + 0.6 < z1; z += 0.7) {
                const double thickness = site.random.uniform(0.002, 0.012);
                const Vector3d up = (point(s, z + 0.6) - point(s, z)).normalized();
                const Vector3d inwards = -at_height(along, 0.0).cross(up);
                add_slab(site.builder, "relief", m, point(s + 0.6, z) + thickness * inwards,
                         at_height(-0.6 * along, 0.0), 0.6 * up, thickness);
            }
        }
    };
    std::vector<Doorway> doorways;
    std::copy_if(room.doorways.begin(), room.doorways.end(), std::back_inserter(doorways),
                 [&](const Doorway& d) { return d.wall == wall; });
    std::sort(doorways.begin(), doorways.end(),
              [](const Doorway& a, const Doorway& b) { return a.along_m < b.along_m; });
    double s = -kBeyond_m;
    for (const Doorway& d : doorways) {
        const double begin = d.along_m - 0.5 * d.width_m;
        const double end = begin + d.width_m;
        piece(s, begin, bottom, top);
        piece(begin, end, bottom, d.sill_z);
        piece(begin, end, d.sill_z + d.height_m, top);
        site.taken[static_cast<std::size_t>(wall)].emplace_back(begin - 0.15, end + 0.15);
        s = end;
    }
    piece(s, length + kBeyond_m, bottom, top);
}

void add_lamps(RoomSite& site) {
    const RoomPlan& room = site.room;
    const int count = std::max(1, static_cast<int>(std::lround(2.0 * room.half.x() / kLampSpacing_m)));
    const Eigen::Rotation2Dd turn(room.yaw_rad);
    for (int i = 0; i < count; ++i) {
        const double x = room.half.x() * ((2.0 * i + 1.0) / count - 1.0);
        const Vector3d at = at_height(room.to_world({x, 0.0}), ceiling_base(room) - kLampDrop_m);
        site.builder.lamp("lamp", site.materials.lamp, at, at_height(turn * Vector2d(0.5, 0.0), 0.0),
                          at_height(turn * Vector2d(0.0, -0.14), 0.0), kLampPower * site.building.light);
    }
}

}  // namespace

void add_slab(SceneBuilder& b, const std::string& name, MaterialId m, const Vector3d& origin, const Vector3d& u,
              const Vector3d& v, double thickness_m) {
    const Vector3d back = -thickness_m * u.cross(v).normalized();
    b.rectangle(name, m, origin, u, v);
    b.rectangle(name + ".side", m, origin, v, back);
    b.rectangle(name + ".side", m, origin + u, back, v);
    b.rectangle(name + ".side", m, origin, back, u);
    b.rectangle(name + ".side", m, origin + v, u, back);
}

void add_shell(RoomSite& site) {
    add_floor(site);
    for (int wall = 0; wall < 4; ++wall) {
        add_wall(site, wall);
    }
    add_ceiling(site);
    add_lamps(site);
}

void add_passage(SceneBuilder& b, const BuildingMaterials& m, const Passage& passage) {
    const Vector2d across(-passage.direction.y(), passage.direction.x());
    const double shorter = std::min(passage.left_m, passage.right_m) + 2.0 * kFrame_m;
    const double longer = std::max(passage.left_m, passage.right_m) + 2.0 * kFrame_m;
    const Vector2d start = passage.start - kFrame_m * passage.direction;
    const Vector2d left = start + 0.5 * passage.width_m * across;
    const Vector2d right = start - 0.5 * passage.width_m * across;
    const Vector3d forward = at_height(passage.direction, 0.0);
    const Vector3d up(0, 0, passage.height_m + 0.05);
    const double z = passage.floor_z;
    b.rectangle("passage.side", m.wood, at_height(left, z - 0.05), (passage.left_m + 2.0 * kFrame_m) * forward, up);
    b.rectangle("passage.side", m.wood, at_height(right, z - 0.05) + (passage.right_m + 2.0 * kFrame_m) * forward,
                -(passage.right_m + 2.0 * kFrame_m) * forward, up);
    const Vector3d width = at_height(passage.width_m * across, 0.0);
    const Vector3d ceiling(0, 0, passage.height_m);
    const Vector3d corner = at_height(right, z);
    b.rectangle("passage.floor", m.fabric, corner, shorter * forward, width);
    b.rectangle("passage.ceiling", m.wood, corner + ceiling, width, shorter * forward);
    if (longer - shorter < 1e-6) {
        return;
    }
    // What an oblique wall leaves open, a triangle each.
    Mesh rest;
    const Vector3d a = corner + shorter * forward;
    const Vector3d tip = (passage.left_m > passage.right_m ? Vector3d(corner + width) : corner) + longer * forward;
    rest.vertices = {a, tip, a + width};
    rest.texture_m = {{0.0, 0.0}, {longer - shorter, 0.0}, {0.0, passage.width_m}};
    rest.triangles = {{0, 1, 2}};
    b.mesh("passage.floor", m.fabric, rest);
    for (Vector3d& vertex : rest.vertices) {
        vertex += ceiling;
    }
    rest.triangles = {{0, 2, 1}};
    b.mesh("passage.ceiling", m.wood, rest);
}

}  // namespace facet::sim
