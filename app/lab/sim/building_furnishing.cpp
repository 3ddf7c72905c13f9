// SPDX-License-Identifier: BSD-2-Clause
// What stands and hangs in a building's rooms, and all its materials.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/lab/sim/building_parts.h"

namespace facet::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWay_m = 0.75;  // to either side of the lines between the middle and the doorways stays free

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
    const double share = std::clamp((p - a).dot(b - a) / std::max(1e-9, (b - a).squaredNorm()), 0.0, 1.0);
    return (p - a - share * (b - a)).norm();
}

/// Whether a thing of this radius leaves the way from the room's middle to its doorways free.
bool is_aside(const RoomPlan& room, const Vector2d& p, double radius_m) {
    return p.norm() > kWay_m + radius_m &&
           std::all_of(room.doorways.begin(), room.doorways.end(), [&](const Doorway& d) {
               return distance_to_segment(p, Vector2d::Zero(), room.on_wall(d.wall, d.along_m)) > kWay_m + radius_m;
           });
}

/// A place that keeps its distance from all walls.
Vector2d draw_place(RoomSite& site, double from_wall_m) {
    const Vector2d reach = (0.9 * site.room.half - Vector2d::Constant(from_wall_m)).cwiseMax(0.05);
    const double x = site.random.uniform(-reach.x(), reach.x());
    return {x, site.random.uniform(-reach.y(), reach.y())};
}

void add_pictures(RoomSite& site) {
    const RoomPlan& room = site.room;
    const int count = static_cast<int>(site.building.richness * site.random.uniform(0.5, 1.5) * room.half.sum());
    const Eigen::Rotation2Dd turn(room.yaw_rad);
    for (int i = 0; i < count; ++i) {
        const int wall = site.random.index(4);
        const double width = site.random.uniform(0.4, 1.1);
        const double height = site.random.uniform(0.4, 1.0);
        const double s = site.reserve(wall, width + 0.1);
        if (s < 0.0) {
            continue;
        }
        const double lean = std::tan(room.wall_lean_rad[static_cast<std::size_t>(wall)]);
        const Vector2d along = turn * room.wall_direction(wall);
        const Vector2d outwards = turn * room.wall_normal(wall);
        const double bottom = room.lowest_floor() - 0.1;
        const double z = site.above_floor(room.on_wall(wall, s), site.random.uniform(0.9, 1.3)).z();
        const Vector2d foot = room.to_world(room.on_wall(wall, s + 0.5 * width)) + lean * (z - bottom) * outwards;
        const Vector3d up = Vector3d(lean * outwards.x(), lean * outwards.y(), 1.0).normalized();
        const Vector3d u = Vector3d(-along.x(), -along.y(), 0.0);
        const double thickness = site.random.uniform(0.012, 0.024);
        add_slab(site.builder, "picture", site.materials.pictures[static_cast<std::size_t>(site.random.index(5))],
                 Vector3d(foot.x(), foot.y(), z) + thickness * u.cross(up), width * u, height * up, thickness);
    }
}

void add_shelf(RoomSite& site) {
    const RoomPlan& room = site.room;
    const double width = site.random.uniform(0.9, 1.4);
    constexpr double kDepth = 0.3;
    const int wall = site.random.index(4);
    const double s = site.reserve(wall, width + 0.1);
    if (s < 0.0) {
        return;
    }
    const Vector2d middle = room.on_wall(wall, s) - (0.5 * kDepth + 0.05) * room.wall_normal(wall);
    if (!is_aside(room, middle, 0.5 * width)) {
        return;
    }
    const Vector2d along = room.wall_direction(wall);
    const double yaw = room.yaw_rad + std::atan2(along.y(), along.x());
    const auto place = [&](double x, double z) {
        const Vector2d p = room.to_world(middle + x * along);
        return Vector3d(p.x(), p.y(), site.above_floor(middle, z).z());
    };
    for (const double x : {-0.5 * width, 0.5 * width}) {
        site.builder.box("shelf.side", site.materials.wood, place(x, 0.95), {0.04, kDepth, 2.0}, yaw);
    }
    for (int i = 0; i < 5; ++i) {
        const double z = 0.05 + 0.46 * i;
        site.builder.box("shelf.board", site.materials.wood, place(0.0, z), {width - 0.04, kDepth, 0.03}, yaw);
        const double filled = site.random.uniform(0.3, 0.9) * width;
        if (i < 4) {
            site.builder.box("shelf.books", site.materials.books, place(0.5 * (filled - width) + 0.04, z + 0.18),
                             {filled - 0.08, 0.2, 0.33}, yaw);
        }
    }
}

void add_table(RoomSite& site) {
    const double length = site.random.uniform(1.0, 1.8);
    const double depth = site.random.uniform(0.6, 0.9);
    const Vector2d at = draw_place(site, 0.5 * length);
    if (!is_aside(site.room, at, 0.4 * length - 0.3)) {
        return;
    }
    const double yaw = site.room.yaw_rad + (site.random.uniform() < 0.5 ? 0.0 : site.random.uniform(-0.6, 0.6));
    const Eigen::Rotation2Dd turn(yaw);
    const Vector3d foot = site.above_floor(at, 0.0);
    const auto place = [&](double x, double y, double z) {
        const Vector2d p = turn * Vector2d(x, y);
        return Vector3d(foot.x() + p.x(), foot.y() + p.y(), foot.z() + z);
    };
    SceneBuilder& b = site.builder;
    b.box("table", site.materials.wood, place(0, 0, 0.74), {length, depth, 0.04}, yaw);
    for (const double x : {-0.5 * length + 0.06, 0.5 * length - 0.06}) {
        for (const double y : {-0.5 * depth + 0.06, 0.5 * depth - 0.06}) {
            b.box("table.leg", site.materials.dark, place(x, y, 0.34), {0.06, 0.06, 0.8}, yaw);
        }
    }
    for (int i = 0; i < 3; ++i) {
        const double x = site.random.uniform(-0.4, 0.4) * length;
        const double y = site.random.uniform(-0.3, 0.3) * depth;
        const double height = site.random.uniform(0.04, 0.25);
        b.box("table.thing", i == 0 ? site.materials.cartons[0] : site.materials.books,
              place(x, y, 0.76 + 0.5 * height),
              {site.random.uniform(0.15, 0.35), site.random.uniform(0.1, 0.25), height}, yaw + i);
    }
}

/// Cartons, barrels, columns and balls.
void add_clutter(RoomSite& site) {
    const int count = 2 + static_cast<int>(site.random.uniform(0.0, 1.2) * site.room.half.prod());
    SceneBuilder& b = site.builder;
    for (int i = 0; i < count; ++i) {
        const Vector2d at = draw_place(site, 0.3);
        const double kind = site.random.uniform();
        const double size = site.random.uniform(0.2, 0.6);
        if (!is_aside(site.room, at, 0.2)) {
            continue;
        }
        const MaterialId carton = site.materials.cartons[static_cast<std::size_t>(site.random.index(3))];
        if (kind < 0.7) {
            b.box("carton", carton, site.above_floor(at, 0.4 * size), {size, 0.8 * size, 0.9 * size},
                  site.random.uniform(0.0, std::numbers::pi));
        } else if (kind < 0.82) {
            b.cylinder("barrel", site.materials.metal, site.above_floor(at, -0.1), {0, 0, 0.95}, 0.27, true);
        } else if (kind < 0.9) {
            b.sphere("ball", site.materials.fabric, site.above_floor(at, 0.18), 0.2);
        } else {
            b.cylinder("column", site.materials.walls[2], site.above_floor(at, -0.1), {0, 0, site.room.height_m + 2.5},
                       0.16);
        }
    }
}

}  // namespace

Vector3d RoomSite::above_floor(const Vector2d& p, double height_m) const {
    const Vector2d world = room.to_world(p);
    return {world.x(), world.y(), room.floor_at(p) + height_m};
}

double RoomSite::reserve(int wall, double width_m) {
    const double length = room.wall_length(wall);
    auto& stretches = taken[static_cast<std::size_t>(wall)];
    for (int attempt = 0; attempt < 8 && length > width_m + 0.2; ++attempt) {
        const double s = random.uniform(0.1 + 0.5 * width_m, length - 0.1 - 0.5 * width_m);
        if (std::none_of(stretches.begin(), stretches.end(), [&](const std::pair<double, double>& t) {
                return s + 0.5 * width_m > t.first && s - 0.5 * width_m < t.second;
            })) {
            stretches.emplace_back(s - 0.5 * width_m, s + 0.5 * width_m);
            return s;
        }
    }
    return -1.0;
}

BuildingMaterials make_building_materials(SceneBuilder& b, double richness, RandomStream& random) {
    const auto contrast = static_cast<float>(0.2 + 0.8 * richness);
    const auto make = [&](Pattern pattern, double tile_m, float dark, float bright, float share, float emission) {
        const float middle = 0.5F * (dark + bright);
        const float half = 0.5F * share * (bright - dark);
        return b.material({pattern, static_cast<std::uint32_t>(100 + random.index(100000)), tile_m, middle - half,
                           middle + half, 0.3F * share, emission});
    };
    BuildingMaterials m;
    m.walls[0] = make(Pattern::kPlain, 2.0, 0.3F, 0.8F, contrast, 0.0F);
    constexpr std::array kWalls{Pattern::kPlaster, Pattern::kBrick,    Pattern::kTiles, Pattern::kStone,
                                Pattern::kPanel,   Pattern::kConcrete, Pattern::kPlanks};
    const int first = random.index(static_cast<int>(kWalls.size()));
    for (std::size_t i = 1; i < m.walls.size(); ++i) {
        m.walls[i] = make(kWalls[(static_cast<std::size_t>(first) + i) % kWalls.size()], random.uniform(1.4, 2.6), 0.1F,
                          0.8F, contrast, 0.0F);
    }
    m.floors = {make(Pattern::kPlanks, 2.0, 0.05F, 0.7F, contrast, 0.0F),
                make(Pattern::kTiles, 1.7, 0.05F, 0.7F, contrast, 0.0F),
                make(Pattern::kFabric, 1.5, 0.05F, 0.6F, contrast, 0.0F)};
    m.ceilings = {make(Pattern::kPanel, 2.4, 0.1F, 0.8F, contrast, 0.0F),
                  make(Pattern::kPlain, 2.0, 0.4F, 0.85F, contrast, 0.0F),
                  make(Pattern::kConcrete, 2.2, 0.15F, 0.7F, contrast, 0.0F)};
    for (MaterialId& carton : m.cartons) {
        carton = make(Pattern::kCarton, 0.0, 0.04F, 0.7F, 1.0F, 0.0F);
    }
    for (std::size_t i = 0; i < m.pictures.size(); ++i) {
        m.pictures[i] = make(i % 2 == 0 ? Pattern::kPoster : Pattern::kPhoto, 0.0, 0.02F, 0.85F, 1.0F, 0.0F);
    }
    m.wood = make(Pattern::kPlanks, 1.1, 0.1F, 0.6F, contrast, 0.0F);
    m.metal = make(Pattern::kMetal, 1.2, 0.03F, 0.7F, 1.0F, 0.0F);
    m.fabric = make(Pattern::kFabric, 1.2, 0.05F, 0.6F, contrast, 0.0F);
    m.dark = make(Pattern::kFabric, 0.5, 0.02F, 0.25F, 1.0F, 0.0F);
    m.books = make(Pattern::kBooks, 1.0, 0.03F, 0.75F, 1.0F, 0.0F);
    m.lamp = make(Pattern::kPlain, 2.0, 0.5F, 0.9F, 1.0F, 1.6F);
    return m;
}

void add_furnishing(RoomSite& site) {
    add_pictures(site);
    if (site.room.is_climb()) {
        return;
    }
    const bool is_corridor = site.room.half.y() < 1.5;
    const int shelves = is_corridor ? 0 : site.random.index(3);
    for (int i = 0; i < shelves; ++i) {
        add_shelf(site);
    }
    const int tables = is_corridor ? 0 : site.random.index(4);
    for (int i = 0; i < tables; ++i) {
        add_table(site);
    }
    add_clutter(site);
}

}  // namespace facet::sim
