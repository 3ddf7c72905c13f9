// SPDX-License-Identifier: BSD-2-Clause
// The plan of a random building: rooms, corridors, ramps and stairs, and the passages between them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace facet::sim {

/// A doorway in a wall.
struct Doorway {
    int wall = 0;           ///< of the room, from its corner of that number to the next
    double along_m = 0.0;   ///< of its middle, from that corner
    double width_m = 1.2;   ///< along the wall
    double height_m = 2.1;  ///< of the lintel above the sill
    double sill_z = 0.0;    ///< in the world
};

enum class FloorKind : std::uint8_t { kFlat, kRamp, kStairs };
enum class CeilingKind : std::uint8_t {
    kFlat,
    kShed,   ///< one slope, low at -y
    kGable,  ///< two slopes that meet in a ridge along x
};

/// A room: a convex quadrilateral about the origin of its own frame, which is turned by yaw about the vertical; the
/// longer sides run along x.
struct RoomPlan {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< in the world
    double yaw_rad = 0.0;
    Eigen::Vector2d half = Eigen::Vector2d::Ones();   ///< of the rectangle around it
    std::array<Eigen::Vector2d, 4> corners{};         ///< counter-clockwise from (-x, -y)
    double floor_z = 0.0;                             ///< of the floor at the centre, or at the foot of a climb
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< of the floor: rise per metre along x and y
    FloorKind floor = FloorKind::kFlat;
    double climb_m = 0.0;  ///< of a ramp or stairs, from -x to +x, between level landings
    CeilingKind ceiling = CeilingKind::kFlat;
    double height_m = 2.6;                  ///< of the ceiling, at its lowest, above the highest floor
    double pitch = 0.0;                     ///< rise of the ceiling per metre along y
    std::array<double, 4> wall_lean_rad{};  ///< of the walls' tops, outwards
    std::vector<Doorway> doorways;

    static constexpr double kLanding_m = 1.0;

    bool is_climb() const { return floor != FloorKind::kFlat; }
    /// World position of a point of the room's frame.
    Eigen::Vector2d to_world(const Eigen::Vector2d& p) const;
    /// Height of the floor in the world; of stairs that of the ramp along their edges.
    double floor_at(const Eigen::Vector2d& p) const;
    double highest_floor() const;
    double lowest_floor() const;
    double wall_length(int wall) const;
    /// Unit vector along a wall and its outward normal, in the room's frame.
    Eigen::Vector2d wall_direction(int wall) const;
    Eigen::Vector2d wall_normal(int wall) const;
    Eigen::Vector2d on_wall(int wall, double along_m) const;
};

/// A short level passage between the doorways of two rooms; it meets the first at a right angle.
struct Passage {
    int from = 0;
    int to = 0;
    Eigen::Vector2d start = Eigen::Vector2d::Zero();       ///< middle of the first doorway, in the world
    Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  ///< unit
    double width_m = 1.2;
    double left_m = 0.5;  ///< lengths of its sides
    double right_m = 0.5;
    double floor_z = 0.0;
    double height_m = 2.1;
};

struct BuildingPlan {
    std::vector<RoomPlan> rooms;
    std::vector<Passage> passages;
    double richness = 1.0;  ///< of texture, 0 to 1
    double light = 1.0;     ///< relative strength of the lamps
};

/// Draws four to seven rooms that do not overlap, each behind a doorway of an earlier one. Heap.
BuildingPlan draw_building(std::uint64_t seed);

}  // namespace facet::sim
