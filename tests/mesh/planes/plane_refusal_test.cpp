// SPDX-License-Identifier: BSD-2-Clause
// What is no plane, however flat parts of it look to noisy landmarks, and what does not refute one.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <random>

#include "tests/mesh/planes/plane_worlds.h"

namespace facet::plane_refusal_test {
namespace {

using Eigen::Vector3d;
using test::looking;
using test::most_planes;
using test::PlaneRig;
using test::PlaneWorld;

const Se3 kFront = looking({1.0, 0.0, 1.2}, 0.0, 0.0);

TEST_CASE("curved walls and floors are no planes") {
    for (const double radius : {0.4, 0.8, 1.5, 3.0}) {
        PlaneWorld pillar;
        const double half = std::min(1.2, 0.9 * radius);
        const auto bulge = [=](double u, double) {
            return std::sqrt(radius * radius - (u - half) * (u - half)) - radius;
        };
        pillar.add({2.5, half, 0.0}, {0.0, -2.0 * half, 0.0}, {0.0, 0.0, 2.4}, 0.15, bulge);
        INFO("radius " << radius);
        CHECK(most_planes(pillar, kFront) == 0);
    }
    PlaneWorld hill;
    hill.add({1.0, -1.5, 0.0}, {3.0, 0.0, 0.0}, {0.0, 3.0, 0.0}, 0.2,
             [](double u, double v) { return 0.25 * std::exp(-((u - 1.5) * (u - 1.5) + (v - 1.5) * (v - 1.5))); });
    CHECK(most_planes(hill, looking({0.0, 0.0, 1.3}, 0.0, 0.4)) == 0);
}

TEST_CASE("stairs are no planes") {
    PlaneWorld world;  // treads of 28 cm, risers of 17 cm
    for (int i = 0; i < 9; ++i) {
        const double x = 1.5 + 0.28 * i;
        const double z = 0.17 * i;
        world.add({x, 0.7, z}, {0.0, -1.4, 0.0}, {0.0, 0.0, 0.17}, 0.09);
        world.add({x, -0.7, z + 0.17}, {0.28, 0.0, 0.0}, {0.0, 1.4, 0.0}, 0.1);
    }
    CHECK(most_planes(world, looking({0.0, 0.0, 1.4}, 0.0, 0.2)) == 0);
}

TEST_CASE("bumpy ground is no plane") {
    for (const double height : {0.05, 0.08, 0.15}) {
        PlaneWorld world;
        world.add({1.0, -1.8, 0.0}, {3.5, 0.0, 0.0}, {0.0, 3.6, 0.0}, 0.15,
                  [=](double u, double v) { return height * std::sin(6.0 * u) * std::cos(5.0 * v + 1.0); });
        INFO("height " << height);
        CHECK(most_planes(world, looking({0.0, 0.0, 1.3}, 0.0, 0.4)) == 0);
    }
}

TEST_CASE("clutter like foliage is no plane") {
    for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
        PlaneWorld world;
        world.random.seed(seed);
        std::uniform_real_distribution<double> uniform(-1.0, 1.0);
        for (int i = 0; i < 500; ++i) {
            world.add_point(
                {2.4 + 0.5 * uniform(world.random), 1.5 * uniform(world.random), 1.2 + 1.1 * uniform(world.random)});
        }
        INFO("seed " << seed);
        CHECK(most_planes(world, kFront) == 0);
    }
}

/// A wall 3 m ahead of the camera with twelve columns and eight rows of landmarks, 2 cm of depth noise.
struct RowsOfLandmarks : PlaneWorld {
    RowsOfLandmarks() {
        noise_px = 0.1;
        add({3.0, 1.8, 0.0}, {0.0, -3.6, 0.0}, {0.0, 0.0, 2.4}, 0.3);
    }
    static std::uint32_t row_of(LandmarkId id) { return id.value % 8; }
};

/// Most planes ever told in some keyframes if `spoil` changes the landmarks of all rows but these.
std::size_t most_planes_with(std::initializer_list<std::uint32_t> rows,
                             const std::function<void(LandmarkSnapshot&)>& spoil) {
    const RowsOfLandmarks world;
    REQUIRE(world.points.size() == 96);
    PlaneRig rig(world);
    std::size_t most = 0;
    for (int k = 0; k < 10; ++k) {
        rig.viewer.view(k + 1, {kFront.q, Vector3d(0.0, 0.04 * (k % 4), 1.2)});
        for (LandmarkSnapshot& s : rig.viewer.last().landmarks) {
            if (std::find(rows.begin(), rows.end(), RowsOfLandmarks::row_of(s.id)) == rows.end()) {
                spoil(s);
            }
        }
        most = std::max(most, rig.step_on(rig.viewer.last()).size());
    }
    return most;
}

TEST_CASE("neighbours too uncertain to be on a plane are no evidence against one that its faces cover") {
    const auto make_uncertain = [](LandmarkSnapshot& s) { s.covariance_W *= 25.0F; };  // 10 cm of depth noise
    const auto move_behind = [](LandmarkSnapshot& s) {
        s.p_W.x() += 0.12 + 0.03 * static_cast<double>(s.id.value % 5);
    };
    CHECK(most_planes_with({3, 4}, make_uncertain) == 1);
    CHECK(most_planes_with({3, 4}, move_behind) == 0);           // known well enough to contradict
    CHECK(most_planes_with({1, 2, 5, 6}, make_uncertain) == 0);  // most of the plane in between is not seen to be one
}

}  // namespace
}  // namespace facet::plane_refusal_test
