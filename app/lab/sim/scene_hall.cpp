// SPDX-License-Identifier: BSD-2-Clause
// Scene "hall": a machine hall of 20 x 12 x 7 m with uneven ground, rough walls, pipes, tanks, heaps and trusses;
// hardly a plane in it.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "app/lab/sim/noise.h"
#include "app/lab/sim/scene.h"
#include "app/support/rng.h"

namespace facet::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kHallX = 10.0;  // half sizes
constexpr double kHallY = 6.0;
constexpr double kHallHeight = 7.0;

struct HallMaterials {
    MaterialId earth, stone, concrete, brick, metal_a, metal_b, hazard, rust, planks, carton, poster, panel, lamp;
};

HallMaterials make_hall_materials(SceneBuilder& b) {
    HallMaterials m{};
    m.earth = b.material({Pattern::kEarth, 11, 2.2, 0.03F, 0.7F, 0.25F, 0.0F});
    m.stone = b.material({Pattern::kStone, 12, 2.6, 0.02F, 0.75F, 0.5F, 0.0F});
    m.concrete = b.material({Pattern::kConcrete, 13, 2.5, 0.03F, 0.75F, 0.5F, 0.0F});
    m.brick = b.material({Pattern::kBrick, 14, 2.2, 0.03F, 0.75F, 0.4F, 0.0F});
    m.metal_a = b.material({Pattern::kMetal, 15, 1.6, 0.02F, 0.75F, 0.4F, 0.0F});
    m.metal_b = b.material({Pattern::kMetal, 16, 0.8, 0.05F, 0.6F, 0.4F, 0.0F});
    m.hazard = b.material({Pattern::kHazard, 17, 0.8, 0.03F, 0.7F, 0.3F, 0.0F});
    m.rust = b.material({Pattern::kPlaster, 18, 0.9, 0.0F, 0.55F, 0.5F, 0.0F});
    m.planks = b.material({Pattern::kPlanks, 19, 1.5, 0.03F, 0.7F, 0.4F, 0.0F});
    m.carton = b.material({Pattern::kCarton, 20, 0.0, 0.02F, 0.7F, 0.0F, 0.0F});
    m.poster = b.material({Pattern::kPoster, 21, 0.0, 0.02F, 0.8F, 0.0F, 0.0F});
    m.panel = b.material({Pattern::kConcrete, 22, 3.0, 0.05F, 0.6F, 0.5F, 0.0F});
    m.lamp = b.material({Pattern::kPlain, 23, 2.0, 0.5F, 0.9F, 0.0F, 1.6F});
    return m;
}

/// Mesh over a grid: point(i / columns, j / rows), texture coordinates in metres from texture().
Mesh grid_mesh(int columns, int rows, const std::function<Vector3d(double, double)>& point,
               const std::function<Vector2d(double, double)>& texture) {
    Mesh mesh;
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i <= columns; ++i) {
            const double u = static_cast<double>(i) / columns;
            const double v = static_cast<double>(j) / rows;
            mesh.vertices.push_back(point(u, v));
            mesh.texture_m.push_back(texture(u, v));
        }
    }
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const int a = j * (columns + 1) + i;
            const int d = a + columns + 1;
            if ((i + j) % 2 == 0) {
                mesh.triangles.push_back({a, a + 1, d + 1});
                mesh.triangles.push_back({a, d + 1, d});
            } else {
                mesh.triangles.push_back({a, a + 1, d});
                mesh.triangles.push_back({a + 1, d + 1, d});
            }
        }
    }
    return mesh;
}

double bumps(double x, double y, double z, double scale, int octaves, std::uint32_t seed) {
    return solid_noise(static_cast<float>(x / scale), static_cast<float>(y / scale), static_cast<float>(z / scale),
                       octaves, seed);
}

struct Heap {
    double x, y, radius, height;
};
constexpr Heap kHeaps[] = {
    {-6.5, 3.6, 2.4, 1.5}, {1.5, -4.2, 2.2, 1.3}, {6.8, 2.8, 2.6, 1.7}, {-2.2, 4.6, 1.5, 0.8}, {-7.6, -3.9, 1.7, 1.0}};

double ground_height(double x, double y) {
    double z = 0.12 * bumps(x, y, 0.0, 1.7, 4, 31);
    for (const Heap& h : kHeaps) {
        const double r = std::hypot(x - h.x, y - h.y) / h.radius;
        if (r < 1.0) {
            z += h.height * (1.0 - r) * (1.0 - r) * (1.0 + 2.0 * r) * (1.0 + 0.35 * bumps(x, y, 0.0, 0.5, 3, 32));
        }
    }
    return z;
}

void add_shell(SceneBuilder& b, const HallMaterials& m) {
    b.mesh("ground", m.earth,
           grid_mesh(
               130, 80,
               [](double u, double v) {
                   const double x = kHallX * (2 * u - 1);
                   const double y = kHallY * (2 * v - 1);
                   return Vector3d(x * 1.02, y * 1.02, ground_height(x, y));
               },
               [](double u, double v) { return Vector2d(2 * kHallX * u, 2 * kHallY * v); }));
    // Walls bulge by decimetres; each is a sheet along `along`, pushed along its inward normal.
    struct Wall {
        const char* name;
        MaterialId material;
        Vector3d corner, along, inward;
    };
    const Wall walls[] = {{"wall.north", m.stone, {-kHallX, kHallY, 0}, {2 * kHallX, 0, 0}, {0, -1, 0}},
                          {"wall.south", m.brick, {kHallX, -kHallY, 0}, {-2 * kHallX, 0, 0}, {0, 1, 0}},
                          {"wall.east", m.concrete, {kHallX, kHallY, 0}, {0, -2 * kHallY, 0}, {-1, 0, 0}},
                          {"wall.west", m.stone, {-kHallX, -kHallY, 0}, {0, 2 * kHallY, 0}, {1, 0, 0}}};
    for (const Wall& w : walls) {
        constexpr double kBeyond = 0.7;  // walls run into each other behind their corners: no gaps
        const double length = w.along.norm() + 2.0 * kBeyond;
        const Vector3d along = w.along.normalized();
        const auto point = [&](double u, double v) {
            const Vector3d base =
                w.corner + (u * length - kBeyond) * along + Vector3d(0, 0, (kHallHeight + 0.6) * v - 0.4);
            const double bulge = 0.32 * bumps(base.x(), base.y(), base.z(), 1.9, 4, 33);
            return Vector3d(base + bulge * w.inward);
        };
        b.mesh(w.name, w.material, grid_mesh(static_cast<int>(length / 0.28), 26, point, [&](double u, double v) {
                   return Vector2d(length * u, kHallHeight * v);
               }));
    }
    b.mesh("vault", m.panel,
           grid_mesh(
               40, 24,
               [](double u, double v) {
                   const double x = kHallX * 1.05 * (1 - 2 * u);
                   const double y = kHallY * 1.08 * (2 * v - 1);
                   return Vector3d(x, y,
                                   kHallHeight - 1.6 * std::pow(y / kHallY, 2) + 0.1 * bumps(x, y, 0.0, 1.5, 3, 34));
               },
               [](double u, double v) { return Vector2d(2 * kHallX * u, 2 * kHallY * v); }));
    for (const double x : {-6.6, -2.2, 2.2, 6.6}) {
        for (const double y : {-2.0, 2.0}) {
            b.lamp("lamp", m.lamp, {x, y, 5.6}, {0.7, 0, 0}, {0, -0.2, 0}, 5.0);
            b.box("lamp.shade", m.metal_b, {x, y, 5.66}, {1.5, 0.5, 0.1});
        }
    }
}

/// A pipe through points, straight cylinders joined by spheres, with flanges along it.
void add_pipe(SceneBuilder& b, MaterialId pipe, MaterialId joint, std::initializer_list<Vector3d> points,
              double radius) {
    const Vector3d* previous = nullptr;
    for (const Vector3d& p : points) {
        if (previous != nullptr) {
            const Vector3d along = p - *previous;
            b.cylinder("pipe", pipe, *previous, along, radius);
            const int flanges = std::max(1, static_cast<int>(along.norm() / 2.3));
            for (int i = 0; i < flanges; ++i) {
                const Vector3d centre = *previous + (i + 0.5) / flanges * along;
                const Vector3d half = 0.04 * along.normalized();
                b.cylinder("flange", joint, centre - half, 2.0 * half, radius * 1.3, true);
            }
        }
        b.sphere("pipe.joint", pipe, p, radius * 1.08);
        previous = &p;
    }
}

/// Four chords with diagonal lacing between two points.
void add_truss(SceneBuilder& b, MaterialId m, const Vector3d& from, const Vector3d& to, double width, int bays) {
    const Vector3d along = to - from;
    const Vector3d x = 0.5 * width * along.unitOrthogonal();
    const Vector3d y = 0.5 * width * along.cross(x).normalized();
    const Vector3d corners[4] = {x + y, x - y, -x - y, -x + y};
    for (int k = 0; k < 4; ++k) {
        b.cylinder("truss.chord", m, from + corners[k], along, 0.035);
        const Vector3d& next = corners[(k + 1) % 4];
        for (int i = 0; i < bays; ++i) {
            const Vector3d a = from + corners[k] + (static_cast<double>(i) / bays) * along;
            const Vector3d c = from + next + (static_cast<double>(i + 1) / bays) * along;
            b.cylinder("truss.lace", m, a, c - a, 0.02);
        }
    }
}

void add_tank(SceneBuilder& b, MaterialId body, MaterialId trim, const Vector3d& base, double radius, double height) {
    b.cylinder("tank", body, base, {0, 0, height}, radius);
    b.sphere("tank.dome", body, base + Vector3d(0, 0, height), radius * 0.9999);
    for (int i = 0; i < 3; ++i) {
        b.cylinder("tank.hoop", trim, base + Vector3d(0, 0, height * (0.2 + 0.3 * i)), {0, 0, 0.09}, radius + 0.03,
                   true);
    }
    for (int i = 0; i < 4; ++i) {
        const double angle = kPi * (0.25 + 0.5 * i);
        b.cylinder("tank.leg", trim,
                   base + Vector3d(0.85 * radius * std::cos(angle), 0.85 * radius * std::sin(angle), -base.z() - 0.3),
                   {0, 0, base.z() + 0.4}, 0.07);
    }
}

/// A boulder: a sphere pushed in and out by noise.
void add_boulder(SceneBuilder& b, MaterialId m, const Vector3d& centre, double radius, std::uint32_t seed) {
    b.mesh("boulder", m,
           grid_mesh(
               18, 10,
               [&](double u, double v) {
                   const double longitude = 2.0 * kPi * (u < 1.0 ? u : 0.0);
                   const double latitude = kPi * (v - 0.5);
                   const Vector3d d(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                                    0.75 * std::sin(latitude));
                   return Vector3d(centre + radius * (1.0 + 0.45 * bumps(d.x(), d.y(), d.z(), 0.7, 3, seed)) * d);
               },
               [&](double u, double v) { return Vector2d(2.0 * kPi * radius * u, kPi * radius * v); }));
}

void add_machines(SceneBuilder& b, const HallMaterials& m) {
    add_tank(b, m.metal_a, m.hazard, {-8.0, -1.2, 0.7}, 1.1, 2.4);
    add_tank(b, m.concrete, m.metal_b, {8.2, -3.6, 0.6}, 1.2, 3.0);
    add_tank(b, m.metal_a, m.rust, {3.6, 4.5, 0.5}, 0.9, 2.0);
    b.sphere("gas.sphere", m.metal_a, {8.4, 0.6, 1.9}, 1.2);
    b.sphere("gas.sphere", m.brick, {-4.6, -4.8, 1.2}, 0.85);
    b.cylinder("boiler", m.metal_a, {-1.6, -5.0, 1.0}, {3.0, 0.5, 0.1}, 0.55, true);
    b.sphere("boiler.end", m.metal_a, {1.4, -4.5, 1.1}, 0.54);
    add_pipe(b, m.rust, m.metal_b, {{-9.5, 5.1, 3.4}, {-1.0, 5.2, 3.1}, {-1.0, 5.2, 0.2}}, 0.22);
    add_pipe(b, m.metal_b, m.hazard, {{-9.3, 4.9, 2.2}, {9.3, 5.1, 2.5}}, 0.13);
    add_pipe(b, m.metal_a, m.rust, {{-9.0, -5.2, 4.2}, {4.0, -5.2, 4.0}, {4.0, -5.2, 1.2}, {9.0, -5.2, 1.0}}, 0.3);
    add_pipe(b, m.rust, m.hazard, {{9.2, -5.0, 2.8}, {9.2, 5.0, 2.6}}, 0.18);
    add_pipe(b, m.metal_b, m.rust, {{-9.2, -5.0, 3.3}, {-9.2, 5.0, 3.0}}, 0.16);
    add_pipe(b, m.metal_a, m.hazard, {{-9.0, 0.5, 4.9}, {9.0, 0.8, 4.9}}, 0.25);
    b.cylinder("column", m.hazard, {-4.0, 2.6, -0.3}, {0, 0, 7.2}, 0.2);
    b.cylinder("column", m.concrete, {4.4, 1.8, -0.3}, {0, 0, 7.2}, 0.26);
    b.cylinder("column", m.rust, {4.9, -2.9, -0.3}, {0, 0, 7.2}, 0.18);
    b.cylinder("drum", m.hazard, {-0.6, 3.9, 0.0}, {0.0, 0.0, 0.95}, 0.31, true);
    b.cylinder("drum", m.metal_b, {0.15, 4.3, 0.0}, {0.0, 0.0, 0.95}, 0.31, true);
    b.cylinder("drum", m.rust, {0.3, 3.4, 0.31}, {0.8, 0.35, 0.0}, 0.31, true);
    b.box("crate", m.planks, {-5.4, -2.6, 0.45}, {0.9, 0.8, 0.9}, 0.5);
    b.box("crate", m.carton, {-5.3, -2.65, 1.15}, {0.6, 0.5, 0.5}, 0.1);
    b.box("sign", m.poster, {4.43, 1.52, 2.2}, {0.7, 0.03, 0.9});
}

void add_clutter(SceneBuilder& b, const HallMaterials& m) {
    for (const double x : {-5.0, 0.0, 5.2}) {
        add_truss(b, m.rust, {x, -5.8, 5.2}, {x + 0.2, 5.8, 5.2}, 0.5, 14);
    }
    add_truss(b, m.metal_b, {-2.9, -3.4, -0.2}, {-2.9, -3.3, 5.2}, 0.42, 9);
    add_truss(b, m.rust, {2.1, 3.1, -0.2}, {2.0, 3.1, 5.2}, 0.42, 9);
    add_truss(b, m.rust, {7.0, -1.2, -0.2}, {7.0, -1.2, 5.2}, 0.4, 9);
    RandomStream random(77, 3);
    for (std::uint32_t i = 0; i < 22; ++i) {
        const double radius = random.uniform(0.12, 0.42);
        const double x = random.uniform(-8.5, 8.5);
        const double y = random.uniform(-4.6, 4.6);
        add_boulder(b, i % 3 == 0 ? m.earth : m.rust, {x, y, ground_height(x, y) + 0.3 * radius}, radius, 90 + i);
    }
}

}  // namespace

Scene make_hall(const SceneDetail& detail) {
    SceneBuilder b("hall");
    const HallMaterials m = make_hall_materials(b);
    add_shell(b, m);
    add_machines(b, m);
    add_clutter(b, m);
    b.ambient(0.5);
    FlightVolume volume;
    volume.low = {-6.8, -3.6, 1.0};
    volume.high = {6.8, 3.4, 3.6};
    volume.start = {-0.6, 0.2, 1.5};
    volume.start_yaw_rad = 2.6;
    volume.clearance_m = 0.5;
    b.flight_volume(volume);
    return b.build(detail);
}

}  // namespace facet::sim
