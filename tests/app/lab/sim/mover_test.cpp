// SPDX-License-Identifier: BSD-2-Clause
// The moving box: planned where there is room, seen where it is, drawn in front of what is behind it and behind what is
// in front of it.
#include "app/lab/sim/mover.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "app/lab/sim/default_rig.h"
#include "app/lab/sim/renderer.h"
#include "tests/app/lab/sim/draft_scene.h"

namespace facet::sim::mover_test {
namespace {

using Eigen::Vector3d;

constexpr SceneDetail kDraft{64, 0.8, 4, 1};

Flight planned(const Scene& scene, std::uint64_t seed, double duration_s) {
    FlightPlan plan;
    plan.duration_s = duration_s;
    plan.seed = seed;
    Flight flight;
    REQUIRE(ok(plan_flight(scene, plan, flight)));
    return flight;
}

/// Share of a coarse picture's pixels that the box changes.
double covered_share(const Renderer& camera, const Scene& scene, const Flight& flight, const Mover& mover, double t) {
    std::vector<std::uint8_t> without;
    std::vector<std::uint8_t> with;
    camera.render({scene, flight}, t, 100.0, 1, without);
    camera.render({scene, flight, &mover}, t, 100.0, 1, with);
    std::size_t changed = 0;
    for (std::size_t i = 0; i < with.size(); ++i) {
        changed += with[i] != without[i] ? 1 : 0;
    }
    return static_cast<double>(changed) / static_cast<double>(with.size());
}

Renderer coarse_camera(const StereoRig& rig) {
    CameraIntrinsics k = rig.left.intrinsics();
    k.width /= 8;
    k.height /= 8;
    k.fx /= 8;
    k.fy /= 8;
    k.cx /= 8;
    k.cy /= 8;
    Photometry quiet;
    quiet.noise = false;
    return {CameraModel(k), rig.T_B_C0, 4, quiet};
}

TEST_CASE("The box crosses the view of a flight, keeps away from the vehicle, and fills a fifth of the picture") {
    const StereoRig rig = euroc_rig();
    const Renderer camera = coarse_camera(rig);
    for (const std::string_view name : scene_names()) {
        INFO(std::string(name));
        const Scene& scene = draft_scene(name);
        const Flight flight = planned(scene, 1, 30.0);
        const Mover mover(kDraft, plan_crossings(scene, flight, rig.T_B_C0, 3.5, 30.0, 1));
        REQUIRE(mover.crossings().size() >= 2);
        double largest = 0.0;
        for (const Crossing& c : mover.crossings()) {
            CHECK(c.begin_s >= 3.5);
            CHECK(c.end_s <= 30.0);
            for (double t = c.begin_s; t <= c.end_s; t += 0.25) {
                const Vector3d box = c.start_W + (t - c.begin_s) * c.v_W;
                CHECK((box - flight.evaluate(t).T_W_B.p).norm() > 0.8);
                largest = std::max(largest, covered_share(camera, scene, flight, mover, t));
            }
            CHECK(covered_share(camera, scene, flight, mover, c.begin_s + 1e-6) < 0.02);
            CHECK(covered_share(camera, scene, flight, mover, c.end_s - 1e-6) < 0.02);
            CHECK(covered_share(camera, scene, flight, mover, c.begin_s - 0.01) == 0.0);
        }
        CHECK(largest > 0.12);
        CHECK(largest < 0.5);
    }
}

/// Rays forward along x from the origin; the scene's surface at `wall` m.
RayPacket forward_rays(float wall) {
    RayPacket p;
    p.origin = {splat(0.0F), F4{-0.9F, -0.2F, 0.2F, 0.9F}, splat(0.0F)};
    p.direction = {splat(1.0F), splat(0.0F), splat(0.0F)};
    p.t = splat(wall);
    p.primitive = I4{7, 7, 7, 7};
    return p;
}

TEST_CASE("Only rays that meet the box before the scene are covered, at the box's place at their own time") {
    Crossing c;
    c.begin_s = 1.0;
    c.end_s = 4.0;
    c.start_W = Vector3d(3.0, -1.0, 0.0);
    c.v_W = Vector3d(0.0, 1.0, 0.0);
    const Mover mover(kDraft, {c});
    CHECK_FALSE(mover.pose(0.99).has_value());
    CHECK_FALSE(mover.pose(4.01).has_value());
    const auto pose = mover.pose(2.0);  // the box's centre is at y = 0, its sides at +-0.375
    REQUIRE(pose.has_value());
    const auto covered = [&](float wall, float tau) {
        float radiance[kLanes] = {-1.0F, -1.0F, -1.0F, -1.0F};
        mover.cover(*pose, splat(tau), forward_rays(wall), 0.002F, radiance);
        std::vector<bool> hit;
        for (const float r : radiance) {
            CHECK((r == -1.0F || r > 0.0F));
            hit.push_back(r > 0.0F);
        }
        return hit;
    };
    CHECK(covered(10.0F, 0.0F) == std::vector<bool>{false, true, true, false});
    CHECK(covered(2.0F, 0.0F) == std::vector<bool>{false, false, false, false});
    CHECK(covered(10.0F, 0.3F) == std::vector<bool>{false, false, true, false});
    CHECK(covered(10.0F, 0.8F) == std::vector<bool>{false, false, false, true});
}

TEST_CASE("Its turn during the exposure is that of its pose a moment later") {
    Crossing c;
    c.end_s = 4.0;
    c.start_W = Vector3d(3.0, -0.4, 0.0);
    c.v_W = Vector3d(0.1, 0.5, 0.0);
    c.yaw_rate_rad_per_s = 0.4;
    const Mover mover({512, 0.8, 4, 1}, {c});
    const auto look = [&](double t, float tau) {
        std::vector<float> radiance(kLanes, -1.0F);
        mover.cover(*mover.pose(t), splat(tau), forward_rays(10.0F), 0.05F, radiance.data());
        return radiance;
    };
    const auto now = look(1.0, 0.02F);
    const auto later = look(1.02, 0.0F);
    for (std::size_t i = 0; i < kLanes; ++i) {
        CHECK(now[i] == Approx(later[i]).margin(0.01));
    }
    CHECK(now[1] > 0.0F);
}

}  // namespace
}  // namespace facet::sim::mover_test
