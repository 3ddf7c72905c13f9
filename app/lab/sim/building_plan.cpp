// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/building_plan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/support/rng.h"
#include "platform/base/angle.h"

namespace facet::sim {
namespace {

using Eigen::Vector2d;

constexpr int kMaxTries = 400;
constexpr double kGap_m = 0.12;                        // between the rectangles around two rooms
constexpr double kJamb_m = 0.4;                        // of wall beside a doorway
constexpr double kSill_m = 0.01;                       // of a passage's floor above that of its rooms
constexpr double kLeanSigma_rad = 0.3 * kRadPerDeg;    // of walls as they are built
constexpr double kLevelSigma_rad = 0.15 * kRadPerDeg;  // of floors that are meant to be level
constexpr double kMaxTilt_rad = 3.0 * kRadPerDeg;

/// A rectangle of any azimuth.
struct Footprint {
    Vector2d centre;
    Vector2d x;  ///< unit
    Vector2d half;
};

Vector2d left_of(const Vector2d& v) { return {-v.y(), v.x()}; }

Vector2d heading(double yaw_rad) { return {std::cos(yaw_rad), std::sin(yaw_rad)}; }

/// Separating axes: those of the sides of both.
bool are_apart(const Footprint& a, const Footprint& b, double gap_m) {
    const Vector2d between = b.centre - a.centre;
    for (const Vector2d& axis : {a.x, left_of(a.x), b.x, left_of(b.x)}) {
        const auto reach = [&](const Footprint& f) {
            return f.half.x() * std::abs(f.x.dot(axis)) + f.half.y() * std::abs(left_of(f.x).dot(axis));
        };
        if (std::abs(between.dot(axis)) > reach(a) + reach(b) + gap_m) {
            return true;
        }
    }
    return false;
}

Footprint footprint_of(const RoomPlan& room) { return {room.centre, heading(room.yaw_rad), room.half}; }

Footprint footprint_of(const Passage& p) {
    const double length = std::max(p.left_m, p.right_m);
    return {p.start + 0.5 * length * p.direction, p.direction, {0.5 * length, 0.5 * p.width_m}};
}

/// Draws the building room by room.
class Architect {
public:
    explicit Architect(std::uint64_t seed) : random_(seed, 61) {
        tilt_rad_ = random_.uniform() < 0.5 ? 0.0 : random_.uniform(0.5, 1.0) * kMaxTilt_rad;
        turns_ = random_.uniform() < 0.7;
        plan_.richness = random_.uniform();
        plan_.light = random_.uniform(0.5, 1.5);
    }

    BuildingPlan draw() {
        const int count = 4 + random_.index(4);
        RoomPlan first = draw_room(false);
        first.yaw_rad = random_.uniform(-std::numbers::pi, std::numbers::pi);
        plan_.rooms.push_back(first);
        for (int tries = 0; tries < kMaxTries && static_cast<int>(plan_.rooms.size()) < count; ++tries) {
            add_room();
        }
        return std::move(plan_);
    }

private:
    RoomPlan draw_room(bool may_climb) {
        RoomPlan room;
        const double kind = random_.uniform();
        const bool is_corridor = kind < 0.35;
        if (may_climb && kind < 0.2) {
            room.floor = kind < 0.1 ? FloorKind::kRamp : FloorKind::kStairs;
            room.climb_m = random_.uniform(0.5, 1.3) * (random_.uniform() < 0.5 ? -1.0 : 1.0);
            room.half = {random_.uniform(2.6, 3.6), random_.uniform(0.9, 1.2)};
        } else if (is_corridor) {
            room.half = {random_.uniform(3.5, 7.5), random_.uniform(0.9, 1.3)};
        } else {
            room.half = {random_.uniform(2.2, 4.0), random_.uniform(1.7, 2.6)};
        }
        const double skew = !room.is_climb() && turns_ && random_.uniform() < 0.5 ? (is_corridor ? 0.04 : 0.12) : 0.0;
        const Vector2d signs[4] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
        for (std::size_t i = 0; i < 4; ++i) {
            const Vector2d inwards(random_.uniform(0.0, skew), random_.uniform(0.0, skew));
            room.corners[i] = signs[i].cwiseProduct(room.half).cwiseProduct(Vector2d::Ones() - inwards);
            room.wall_lean_rad[i] = kLeanSigma_rad * random_.normal();
        }
        if (!room.is_climb()) {
            const double tilt = tilt_rad_ > 0.0 ? random_.uniform(0.0, tilt_rad_) : kLevelSigma_rad * random_.normal();
            room.slope = std::tan(tilt) * heading(random_.uniform(-std::numbers::pi, std::numbers::pi));
        }
        room.height_m = random_.uniform(2.45, 3.1);
        const double roof = random_.uniform();
        if (!room.is_climb() && !is_corridor && roof < 0.45) {
            room.ceiling = roof < 0.2 ? CeilingKind::kShed : CeilingKind::kGable;
            room.pitch = std::tan(random_.uniform(8.0, 28.0) * kRadPerDeg);
        }
        return room;
    }

    /// A wall and place for a doorway; climbs have theirs on the landings.
    bool draw_doorway(const RoomPlan& room, Doorway& doorway) {
        doorway.wall = room.is_climb() ? 1 + 2 * random_.index(2) : random_.index(4);
        const double room_left = room.wall_length(doorway.wall) - doorway.width_m - 2.0 * kJamb_m;
        if (room_left < 0.0) {
            doorway.along_m = 0.5 * room.wall_length(doorway.wall);
            return room.wall_length(doorway.wall) > doorway.width_m + 0.3;
        }
        doorway.along_m = kJamb_m + 0.5 * doorway.width_m + random_.uniform(0.0, room_left);
        return std::none_of(room.doorways.begin(), room.doorways.end(), [&](const Doorway& other) {
            return other.wall == doorway.wall &&
                   std::abs(other.along_m - doorway.along_m) < 0.5 * (other.width_m + doorway.width_m) + 2.0 * kJamb_m;
        });
    }

    /// Tries to put a room behind a new doorway of one of the rooms so far, mostly the latest.
    void add_room() {
        const int from = random_.uniform() < 0.5 ? static_cast<int>(plan_.rooms.size()) - 1
                                                 : random_.index(static_cast<int>(plan_.rooms.size()));
        RoomPlan& host = plan_.rooms[static_cast<std::size_t>(from)];
        RoomPlan room = draw_room(!host.is_climb());
        Doorway out;
        Doorway in;
        out.width_m = in.width_m = random_.uniform(1.15, 1.45);
        if (!draw_doorway(host, out) || !draw_doorway(room, in)) {
            return;
        }
        const Vector2d door = host.on_wall(out.wall, out.along_m);
        const Vector2d normal = host.wall_normal(out.wall);
        Passage passage;
        passage.from = from;
        passage.to = static_cast<int>(plan_.rooms.size());
        passage.start = host.to_world(door);
        passage.direction = Eigen::Rotation2Dd(host.yaw_rad) * normal;
        passage.width_m = out.width_m;
        passage.floor_z = host.floor_at(door) + kSill_m;
        out.sill_z = in.sill_z = passage.floor_z;

        const double turn = turns_ && random_.uniform() < 0.6 ? random_.uniform(-25.0, 25.0) * kRadPerDeg : 0.0;
        in.width_m /= std::cos(turn);
        const Vector2d inner_normal = room.wall_normal(in.wall);
        room.yaw_rad = std::atan2(-passage.direction.y(), -passage.direction.x()) + turn -
                       std::atan2(inner_normal.y(), inner_normal.x());
        const double length = random_.uniform(0.25, 1.6);
        const Vector2d entry = room.on_wall(in.wall, in.along_m);
        room.centre = passage.start + length * passage.direction - Eigen::Rotation2Dd(room.yaw_rad) * entry;
        room.floor_z += passage.floor_z - kSill_m - room.floor_at(entry);
        // Where the sides meet the other wall: its normal is turned against the passage.
        passage.left_m = length - 0.5 * passage.width_m * std::tan(turn);
        passage.right_m = length + 0.5 * passage.width_m * std::tan(turn);
        if (std::min(passage.left_m, passage.right_m) < 0.1 || !fits(room, passage)) {
            return;
        }
        host.doorways.push_back(out);
        room.doorways.push_back(in);
        plan_.passages.push_back(passage);
        plan_.rooms.push_back(room);
    }

    bool fits(const RoomPlan& room, const Passage& passage) const {
        const Footprint body = footprint_of(room);
        const Footprint way = footprint_of(passage);
        for (std::size_t i = 0; i < plan_.rooms.size(); ++i) {
            const Footprint other = footprint_of(plan_.rooms[i]);
            if (!are_apart(body, other, kGap_m) ||
                (static_cast<int>(i) != passage.from && !are_apart(way, other, kGap_m))) {
                return false;
            }
        }
        return std::all_of(plan_.passages.begin(), plan_.passages.end(), [&](const Passage& p) {
            return are_apart(body, footprint_of(p), kGap_m) && are_apart(way, footprint_of(p), kGap_m);
        });
    }

    RandomStream random_;
    BuildingPlan plan_;
    double tilt_rad_ = 0.0;  ///< most that a floor may have
    bool turns_ = true;      ///< walls of other azimuths than a quarter turn
};

}  // namespace

Vector2d RoomPlan::to_world(const Vector2d& p) const { return centre + Eigen::Rotation2Dd(yaw_rad) * p; }

double RoomPlan::floor_at(const Vector2d& p) const {
    if (!is_climb()) {
        return floor_z + slope.dot(p);
    }
    const double share = (p.x() + half.x() - kLanding_m) / (2.0 * (half.x() - kLanding_m));
    return floor_z + climb_m * std::clamp(share, 0.0, 1.0);
}

double RoomPlan::highest_floor() const {
    return is_climb() ? floor_z + std::max(0.0, climb_m) : floor_z + slope.cwiseAbs().dot(half);
}

double RoomPlan::lowest_floor() const {
    return is_climb() ? floor_z + std::min(0.0, climb_m) : floor_z - slope.cwiseAbs().dot(half);
}

double RoomPlan::wall_length(int wall) const {
    return (corners[static_cast<std::size_t>((wall + 1) % 4)] - corners[static_cast<std::size_t>(wall)]).norm();
}

Vector2d RoomPlan::wall_direction(int wall) const {
    return (corners[static_cast<std::size_t>((wall + 1) % 4)] - corners[static_cast<std::size_t>(wall)]).normalized();
}

Vector2d RoomPlan::wall_normal(int wall) const { return -left_of(wall_direction(wall)); }

Vector2d RoomPlan::on_wall(int wall, double along_m) const {
    return corners[static_cast<std::size_t>(wall)] + along_m * wall_direction(wall);
}

BuildingPlan draw_building(std::uint64_t seed) { return Architect(seed).draw(); }

}  // namespace facet::sim
