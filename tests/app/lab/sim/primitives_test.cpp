// SPDX-License-Identifier: BSD-2-Clause
// Surfaces: parametrisation, distance and intersection, each against the others.
#include "app/lab/sim/primitives.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <vector>

#include "app/support/rng.h"

namespace facet::sim::primitives_test {
namespace {

using Eigen::Vector3d;

Vector3d random_vector(RandomStream& random, double reach) {
    return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

std::vector<SurfaceShape> random_shapes(std::uint64_t seed) {
    RandomStream random(seed, 5);
    std::vector<SurfaceShape> shapes;
    for (int i = 0; i < 40; ++i) {
        SurfaceShape s;
        s.shape = static_cast<Shape>(i % 5);
        s.origin = random_vector(random, 2.0);
        const Vector3d axis = random_vector(random, 1.0).normalized();
        const Vector3d side = axis.unitOrthogonal();
        s.radius = random.uniform(0.1, 0.8);
        s.edge_v = random.uniform(0.3, 1.5) * axis;
        s.edge_u = s.shape == Shape::kCylinder ? side : Vector3d(random.uniform(0.3, 1.5) * side);
        if (s.shape == Shape::kTriangle) {
            s.edge_u += 0.4 * axis;
        } else if (s.shape == Shape::kDisk) {
            s.edge_u = side * s.edge_v.norm();
        }
        shapes.push_back(s);
    }
    return shapes;
}

bool inside(const SurfaceShape& s, double u, double v) {
    if (s.shape == Shape::kTriangle) {
        return u + v <= 1.0;
    }
    return s.shape != Shape::kDisk || std::hypot(2 * u - 1, 2 * v - 1) <= 1.0;
}

/// Sphere tracing: steps by the distance to the surface, an independent way to find the first hit.
double trace(const SurfaceShape& s, const Vector3d& origin, const Vector3d& direction, double reach) {
    double t = 0.0;
    for (int i = 0; i < 20000 && t < reach; ++i) {
        const double d = surface_distance(s, origin + t * direction);
        if (d < 1e-6) {
            return t;
        }
        t += d;
    }
    return reach;
}

TEST_CASE("Points of a surface lie on it, at the parameters they came from") {
    RandomStream random(1, 6);
    for (const SurfaceShape& s : random_shapes(11)) {
        const Primitive primitive = make_primitive(s, 0);
        const Box box = surface_box(s);
        for (int k = 0; k < 50; ++k) {
            const double u = random.uniform(0.02, 0.98);
            const double v = random.uniform(0.02, 0.98);
            if (!inside(s, u, v)) {
                continue;
            }
            const Vector3d p = surface_point(s, u, v);
            CHECK(surface_distance(s, p) < 1e-9);
            const Eigen::Vector3f pf = p.cast<float>();
            CHECK(((pf - box.low).minCoeff() >= 0.0F && (box.high - pf).minCoeff() >= 0.0F));
            const Eigen::Vector3f n = surface_normal(s, u, v).cast<float>();
            const SurfaceHit hit = locate(primitive, pf.data(), n.data());
            CHECK(std::abs(hit.u - u) < 2e-4);
            CHECK(std::abs(hit.v - v) < 2e-4);
            CHECK(hit.cos == Approx(1.0).epsilon(1e-4));
            CHECK(surface_distance(s, p + 1e-3 * n.cast<double>()) == Approx(1e-3).epsilon(1e-3));
        }
    }
}

TEST_CASE("Ray intersections agree with sphere tracing") {
    RandomStream random(2, 6);
    int hits = 0;
    for (const SurfaceShape& s : random_shapes(12)) {
        const Primitive primitive = make_primitive(s, 0);
        for (int k = 0; k < 40; ++k) {
            const Vector3d origin = random_vector(random, 4.0);
            const Vector3d aim = surface_point(s, 0.4, 0.4) + random_vector(random, 0.5);
            const Vector3d d = (aim - origin).normalized();
            RayPacket packet;
            const auto lanes = [](double x) { return splat(static_cast<float>(x)); };
            packet.origin = {lanes(origin.x()), lanes(origin.y()), lanes(origin.z())};
            packet.direction = {lanes(d.x()), lanes(d.y()), lanes(d.z())};
            packet.t = splat(RayPacket::kFar);
            packet.primitive = I4{-1, -1, -1, -1};
            intersect(primitive, 7, packet);
            const double expected = trace(s, origin, d, 30.0);
            // Rays that graze an edge or a silhouette may go either way in single precision: such rays are found
            // by moving them a little.
            const Vector3d beside = 2e-4 * d.unitOrthogonal();
            const bool clear_cut = std::abs(trace(s, origin + beside, d, 30.0) - expected) < 0.02 &&
                                   std::abs(trace(s, origin - beside, d, 30.0) - expected) < 0.02;
            if (!clear_cut) {
                continue;
            }
            CHECK((packet.primitive[2] == 7) == (expected < 30.0));
            if (expected < 30.0) {
                ++hits;
                CHECK(std::abs(packet.t[2] - expected) < 2e-4);
            }
        }
    }
    CHECK(hits > 500);
}

}  // namespace
}  // namespace facet::sim::primitives_test
