// SPDX-License-Identifier: BSD-2-Clause
// The tree finds what testing every surface finds: packets, bundles, distances.
#include "app/lab/sim/bvh.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "app/support/rng.h"
#include "tests/app/lab/sim/draft_scene.h"

namespace facet::sim::bvh_test {
namespace {

using Eigen::Vector3d;

Vector3d random_point(const Scene& scene, RandomStream& random) {
    const FlightVolume& volume = scene.flight_volume();
    Vector3d p;
    for (int i = 0; i < 3; ++i) {
        p[i] = random.uniform(volume.low[i], volume.high[i]);
    }
    return p;
}

RayPacket random_packet(const Vector3d& origin, const Vector3d& towards, double spread, RandomStream& random) {
    RayPacket r;
    for (int i = 0; i < kLanes; ++i) {
        const Vector3d d =
            (towards + spread * Vector3d(random.normal(), random.normal(), random.normal())).normalized();
        r.origin.x[i] = static_cast<float>(origin.x());
        r.origin.y[i] = static_cast<float>(origin.y());
        r.origin.z[i] = static_cast<float>(origin.z());
        r.direction.x[i] = static_cast<float>(d.x());
        r.direction.y[i] = static_cast<float>(d.y());
        r.direction.z[i] = static_cast<float>(d.z());
    }
    r.t = splat(RayPacket::kFar);
    r.primitive = I4{-1, -1, -1, -1};
    return r;
}

void check_same(const RayPacket& a, const RayPacket& b) {
    for (int i = 0; i < kLanes; ++i) {
        CHECK(a.t[i] == b.t[i]);  // the same test on the same primitive: equal to the bit
        CHECK((a.primitive[i] >= 0) == (b.primitive[i] >= 0));
    }
}

TEST_CASE("Packets and bundles find the nearest of all surfaces") {
    for (const std::string_view name : scene_names()) {
        const Scene& scene = draft_scene(name);
        const auto primitives = scene.bvh().primitives();
        RandomStream random(4, 8);
        for (int k = 0; k < 40; ++k) {
            const Vector3d origin = random_point(scene, random);
            const Vector3d towards = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
            const double spread = k % 2 == 0 ? 0.02 : 0.6;  // like neighbouring pixels, and all over the place
            std::vector<RayPacket> bundle;
            for (int i = 0; i < 6; ++i) {
                bundle.push_back(random_packet(origin, towards, spread, random));
            }
            std::vector<RayPacket> single = bundle;
            std::vector<RayPacket> brute = bundle;
            scene.bvh().intersect_bundle(bundle);
            for (std::size_t i = 0; i < single.size(); ++i) {
                scene.bvh().intersect(single[i]);
                for (std::size_t p = 0; p < primitives.size(); ++p) {
                    intersect(primitives[p], static_cast<int>(p), brute[i]);
                }
                check_same(single[i], brute[i]);
                check_same(bundle[i], brute[i]);
            }
        }
    }
}

TEST_CASE("Clearance is the least distance over all surfaces") {
    const Scene& scene = draft_scene("room");
    RandomStream random(6, 8);
    for (int k = 0; k < 100; ++k) {
        const Vector3d p = random_point(scene, random);
        double nearest = 1.0;
        for (const SurfaceShape& s : scene.shapes()) {
            nearest = std::min(nearest, surface_distance(s, p));
        }
        CHECK(scene.clearance(p, 1.0) == Approx(nearest));
    }
}

TEST_CASE("Scenes are closed: every ray hits something, on the surface it names") {
    for (const std::string_view name : scene_names()) {
        const Scene& scene = draft_scene(name);
        RandomStream random(5, 8);
        for (int k = 0; k < 2000; ++k) {
            const Vector3d start = scene.flight_volume().start;
            const Vector3d target = random_point(scene, random);
            // Up to 90 % of the free way: the target itself may lie inside a heap.
            const RayHit way = scene.cast(start, (target - start).normalized());
            REQUIRE(way.surface >= 0);
            const Vector3d origin =
                start + 0.9 * std::min(way.distance, (target - start).norm()) * (target - start).normalized();
            const Vector3d d = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
            const RayHit hit = scene.cast(origin, d);
            INFO(name << " from " << origin.transpose() << " along " << d.transpose());
            REQUIRE(hit.surface >= 0);
            const SurfaceShape& s = scene.shapes()[static_cast<std::size_t>(hit.surface)];
            CHECK(surface_distance(s, origin + hit.distance * d) < 1e-3);
            CHECK((surface_point(s, hit.u, hit.v) - origin - hit.distance * d).norm() < 2e-3);
        }
    }
}

}  // namespace
}  // namespace facet::sim::bvh_test
