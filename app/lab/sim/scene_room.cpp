// SPDX-License-Identifier: BSD-2-Clause
// Scene "room": a furnished room of 8 x 6 x 3.2 m, mostly planes, with two columns and a ball.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "app/lab/sim/scene.h"
#include "app/support/rng.h"

namespace facet::sim {
namespace {

using Eigen::Vector3d;

constexpr double kRoomX = 4.0;  // half sizes
constexpr double kRoomY = 3.0;
constexpr double kRoomHeight = 3.2;

struct RoomMaterials {
    MaterialId plain, plaster, brick, planks, tiles, wood, panel, fabric, carton_a, carton_b, carton_c, metal, stone,
        hazard, books, door, window, lamp, dark;
    MaterialId pictures[6];
};

RoomMaterials make_room_materials(SceneBuilder& b) {
    RoomMaterials m{};
    m.plain = b.material({Pattern::kPlain, 11, 2.0, 0.2F, 0.75F, 0.15F, 0.0F});
    m.plaster = b.material({Pattern::kPlaster, 12, 2.2, 0.05F, 0.8F, 0.3F, 0.0F});
    m.brick = b.material({Pattern::kBrick, 13, 2.1, 0.03F, 0.75F, 0.3F, 0.0F});
    m.planks = b.material({Pattern::kPlanks, 14, 2.0, 0.03F, 0.7F, 0.35F, 0.0F});
    m.tiles = b.material({Pattern::kTiles, 15, 1.6, 0.03F, 0.75F, 0.3F, 0.0F});
    m.wood = b.material({Pattern::kPlanks, 16, 1.1, 0.1F, 0.6F, 0.3F, 0.0F});
    m.panel = b.material({Pattern::kPanel, 17, 2.4, 0.08F, 0.8F, 0.3F, 0.0F});
    m.fabric = b.material({Pattern::kFabric, 18, 1.3, 0.03F, 0.65F, 0.25F, 0.0F});
    m.carton_a = b.material({Pattern::kCarton, 19, 0.0, 0.02F, 0.7F, 0.0F, 0.0F});
    m.carton_b = b.material({Pattern::kCarton, 20, 0.0, 0.02F, 0.55F, 0.0F, 0.0F});
    m.carton_c = b.material({Pattern::kCarton, 21, 0.0, 0.05F, 0.8F, 0.0F, 0.0F});
    m.metal = b.material({Pattern::kMetal, 22, 1.2, 0.03F, 0.7F, 0.2F, 0.0F});
    m.stone = b.material({Pattern::kStone, 23, 1.5, 0.03F, 0.75F, 0.3F, 0.0F});
    m.hazard = b.material({Pattern::kHazard, 24, 0.9, 0.03F, 0.75F, 0.2F, 0.0F});
    m.books = b.material({Pattern::kBooks, 25, 1.0, 0.03F, 0.75F, 0.0F, 0.0F});
    m.door = b.material({Pattern::kDoor, 26, 0.0, 0.03F, 0.7F, 0.0F, 0.0F});
    m.window = b.material({Pattern::kWindow, 27, 0.0, 0.1F, 0.8F, 0.0F, 0.7F});
    m.lamp = b.material({Pattern::kPlain, 28, 2.0, 0.5F, 0.9F, 0.0F, 1.6F});
    m.dark = b.material({Pattern::kFabric, 29, 0.5, 0.02F, 0.25F, 0.2F, 0.0F});
    for (int i = 0; i < 6; ++i) {
        const auto seed = 40U + static_cast<std::uint32_t>(i);
        m.pictures[i] =
            b.material({i % 2 == 0 ? Pattern::kPoster : Pattern::kPhoto, seed, 0.0, 0.02F, 0.85F, 0.0F, 0.0F});
    }
    return m;
}

void add_shell(SceneBuilder& b, const RoomMaterials& m) {
    b.rectangle("floor", m.planks, {-kRoomX, -kRoomY, 0}, {2 * kRoomX, 0, 0}, {0, 2 * kRoomY, 0});
    b.rectangle("ceiling", m.panel, {-kRoomX, kRoomY, kRoomHeight}, {2 * kRoomX, 0, 0}, {0, -2 * kRoomY, 0});
    b.rectangle("wall.north", m.brick, {-kRoomX, kRoomY, 0}, {2 * kRoomX, 0, 0}, {0, 0, kRoomHeight});
    b.rectangle("wall.south", m.plaster, {kRoomX, -kRoomY, 0}, {-2 * kRoomX, 0, 0}, {0, 0, kRoomHeight});
    b.rectangle("wall.west", m.plain, {-kRoomX, -kRoomY, 0}, {0, 2 * kRoomY, 0}, {0, 0, kRoomHeight});
    b.rectangle("wall.east", m.stone, {kRoomX, kRoomY, 0}, {0, -2 * kRoomY, 0}, {0, 0, kRoomHeight});
    // Skirting, and a tiled wainscot on the south wall.
    b.box("skirting", m.wood, {0, kRoomY - 0.01, 0.06}, {2 * kRoomX, 0.02, 0.12});
    b.box("skirting", m.wood, {-kRoomX + 0.01, 0, 0.06}, {0.02, 2 * kRoomY - 0.06, 0.12});
    b.box("wainscot", m.tiles, {0.9, -kRoomY + 0.015, 0.55}, {5.0, 0.03, 1.1});
    b.box("rug", m.fabric, {-0.6, -0.4, 0.005}, {2.6, 1.9, 0.01}, 0.15);
    const double lamp_x[] = {-2.0, 0.1, 2.1};
    for (const double x : lamp_x) {
        b.lamp("lamp", m.lamp, {x, 0.2 * x, kRoomHeight - 0.03}, {0.55, 0, 0}, {0, -0.16, 0}, 2.1);
    }
    b.lamp("window", m.window, {kRoomX - 0.02, 0.9, 1.75}, {0, -0.75, 0}, {0, 0, 0.6}, 2.2);
    for (const double z : {1.12, 2.38}) {
        b.box("window.frame", m.wood, {kRoomX - 0.03, 0.9, z}, {0.06, 1.66, 0.07});
    }
    for (const double y : {0.12, 1.68}) {
        b.box("window.frame", m.wood, {kRoomX - 0.03, y, 1.75}, {0.06, 0.07, 1.2});
    }
}

/// A framed picture: thin box whose large side faces along `normal` (+-x or +-y).
void add_picture(SceneBuilder& b, MaterialId frame, MaterialId picture, const Vector3d& centre, const Vector3d& normal,
                 double width, double height) {
    const Vector3d across = normal.cross(Vector3d::UnitZ());  // to the viewer's left
    const Vector3d u = -across;
    Vector3d size = (0.018 * normal + (width + 0.06) * across).cwiseAbs();
    size.z() = height + 0.06;
    b.box("frame", frame, centre + 0.009 * normal, size);
    const Vector3d corner = centre + 0.02 * normal - 0.5 * width * u - 0.5 * height * Vector3d::UnitZ();
    b.rectangle("picture", picture, corner, width * u, Vector3d(0, 0, height));
}

void add_pictures(SceneBuilder& b, const RoomMaterials& m) {
    const Vector3d north(0, -1, 0);
    const Vector3d south(0, 1, 0);
    const Vector3d west(1, 0, 0);
    const Vector3d east(-1, 0, 0);
    add_picture(b, m.dark, m.pictures[0], {-2.6, kRoomY, 1.7}, north, 0.9, 1.2);
    add_picture(b, m.wood, m.pictures[1], {-1.1, kRoomY, 1.9}, north, 1.2, 0.8);
    add_picture(b, m.dark, m.pictures[2], {2.9, kRoomY, 1.8}, north, 0.8, 1.1);
    add_picture(b, m.wood, m.pictures[3], {-1.9, -kRoomY, 1.75}, south, 1.3, 0.9);
    add_picture(b, m.dark, m.pictures[4], {0.2, -kRoomY, 2.0}, south, 0.8, 0.8);
    add_picture(b, m.dark, m.pictures[5], {2.4, -kRoomY, 1.9}, south, 1.1, 0.8);
    add_picture(b, m.wood, m.pictures[2], {-kRoomX, 0.2, 1.8}, west, 0.9, 1.2);
    add_picture(b, m.dark, m.pictures[1], {-kRoomX, -1.9, 1.6}, west, 1.0, 0.7);
    add_picture(b, m.dark, m.pictures[3], {kRoomX, -1.4, 1.9}, east, 1.1, 0.8);
    b.box("door", m.door, {-kRoomX + 0.02, 2.0, 1.02}, {0.04, 0.92, 2.04});
    b.box("door.frame", m.dark, {-kRoomX + 0.03, 1.5, 1.05}, {0.06, 0.08, 2.1});
    b.box("door.frame", m.dark, {-kRoomX + 0.03, 2.5, 1.05}, {0.06, 0.08, 2.1});
}

void add_table(SceneBuilder& b, const RoomMaterials& m, const Vector3d& at, double yaw) {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    const auto place = [&](double x, double y, double z) {
        return Vector3d(at.x() + c * x - s * y, at.y() + s * x + c * y, z);
    };
    b.box("table", m.wood, place(0, 0, 0.74), {1.6, 0.8, 0.04}, yaw);
    for (const double x : {-0.72, 0.72}) {
        for (const double y : {-0.33, 0.33}) {
            b.box("table.leg", m.dark, place(x, y, 0.36), {0.06, 0.06, 0.72}, yaw);
        }
    }
    b.sphere("ball", m.hazard, place(-0.4, 0.1, 0.76 + 0.16), 0.16);
    b.box("carton", m.carton_c, place(0.35, -0.1, 0.76 + 0.11), {0.4, 0.3, 0.22}, yaw + 0.4);
    b.box("book", m.books, place(0.1, 0.2, 0.76 + 0.03), {0.25, 0.18, 0.06}, yaw - 0.3);
    b.cylinder("cup", m.metal, place(-0.05, -0.22, 0.76), {0, 0, 0.12}, 0.045, true);
}

void add_furniture(SceneBuilder& b, const RoomMaterials& m) {
    add_table(b, m, {-1.2, 1.6, 0}, 0.1);
    add_table(b, m, {2.5, -1.7, 0}, 1.3);
    // Shelf with books on the north wall.
    const double shelf_x = 0.9;
    for (const double x : {shelf_x - 0.62, shelf_x + 0.62}) {
        b.box("shelf.side", m.wood, {x, kRoomY - 0.17, 1.0}, {0.04, 0.32, 2.0});
    }
    for (int i = 0; i < 5; ++i) {
        const double z = 0.05 + 0.47 * i;
        b.box("shelf.board", m.wood, {shelf_x, kRoomY - 0.17, z}, {1.2, 0.32, 0.03});
        if (i < 4) {
            const double half = 0.42 + 0.05 * (i % 3);
            b.box("shelf.books", m.books, {shelf_x - 0.55 + half, kRoomY - 0.2, z + 0.19}, {2.0 * half, 0.2, 0.34});
        }
    }
    b.cylinder("column", m.stone, {1.2, 0.9, 0}, {0, 0, kRoomHeight}, 0.22);
    b.cylinder("column", m.hazard, {-2.9, -1.7, 0}, {0, 0, kRoomHeight}, 0.17);
    b.cylinder("barrel", m.metal, {-3.3, -2.4, 0}, {0, 0, 0.95}, 0.3, true);
    b.cylinder("pipe", m.metal, {-kRoomX, -kRoomY + 0.25, 2.9}, {2 * kRoomX, 0, 0}, 0.06);
    b.box("cabinet", m.metal, m.wood, {3.55, 2.4, 0.6}, {0.8, 0.9, 1.2});
    b.box("radiator", m.panel, {kRoomX - 0.12, 0.9, 0.5}, {0.14, 1.4, 0.6});
    b.box("carton", m.carton_a, {-3.4, 1.0, 0.3}, {0.7, 0.55, 0.6}, 0.25);
    b.box("carton", m.carton_b, {-3.42, 0.98, 0.8}, {0.5, 0.45, 0.4}, -0.2);
    b.box("carton", m.carton_c, {-0.9, -2.45, 0.25}, {0.6, 0.5, 0.5}, 0.5);
    b.box("carton", m.carton_a, {0.9, -2.5, 0.35}, {0.55, 0.55, 0.7}, -0.15);
    b.box("carton", m.carton_b, {0.9, -2.48, 0.88}, {0.42, 0.4, 0.36}, 0.3);
    b.box("crate", m.planks, {3.3, 1.1 - 2.0, 0.3}, {0.6, 0.6, 0.6}, 0.35);
    RandomStream random(2024, 1);
    for (int i = 0; i < 9; ++i) {  // bricks and books scattered on the floor: small things near the ground
        const double x = random.uniform(-2.8, 2.6);
        const double y = random.uniform(-2.0, 0.6);
        const double h = random.uniform(0.05, 0.16);
        b.box("block", i % 2 == 0 ? m.books : m.brick, {x, y, 0.011 + 0.5 * h},
              {random.uniform(0.15, 0.3), random.uniform(0.1, 0.2), h}, random.uniform(0.0, std::numbers::pi));
    }
}

}  // namespace

Scene make_room(const SceneDetail& detail) {
    SceneBuilder b("room");
    const RoomMaterials m = make_room_materials(b);
    add_shell(b, m);
    add_pictures(b, m);
    add_furniture(b, m);
    b.ambient(0.42);
    FlightVolume volume;
    volume.low = {-3.2, -2.2, 0.8};
    volume.high = {3.2, 2.2, 2.1};
    volume.start = {-0.2, -0.6, 1.35};
    volume.start_yaw_rad = 1.9;
    volume.clearance_m = 0.4;
    b.flight_volume(volume);
    return b.build(detail);
}

}  // namespace facet::sim
