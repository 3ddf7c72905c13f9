// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/obstacle_sweep.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>

namespace facet {
namespace {

/// An upright wall 4 m east of the origin, from 1 m south to 1 m north, 2 m high.
std::unique_ptr<HorizonMesh> wall() {
    auto mesh = std::make_unique<HorizonMesh>();
    const Eigen::Vector3d corners[] = {{4, -1, -1}, {4, 1, -1}, {4, 1, 1}, {4, -1, 1}};
    std::array<VertexSlot, 4> slots{};
    for (std::size_t i = 0; i < slots.size(); ++i) {
        slots[i] = mesh->add_vertex(LandmarkId(static_cast<std::uint32_t>(i + 1))).value();
        mesh->vertex(slots[i]).measured_W = corners[i];
    }
    for (const auto& [b, c] : {std::pair{1U, 2U}, std::pair{2U, 3U}}) {
        const FaceIndex face = mesh->add_face({slots[0], slots[b], slots[c]}).value();
        mesh->face(face).observations = 3;
    }
    return mesh;
}

Estimate facing(double heading_rad, Timestamp stamp) {
    Estimate estimate;
    estimate.stamp = stamp;
    estimate.state.q_W_B = Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ());
    return estimate;
}

TEST_CASE("a wall is where it is seen from the body: ahead, then to the right; what has no face is unknown") {
    ObstacleSweep sweep({});
    sweep.update(*wall());
    ObstacleRanges ranges;
    REQUIRE(sweep.sweep(facing(0.0, {0}), ranges));
    CHECK(ranges.range_m[0] == Approx(4.0));
    CHECK(ranges.range_m[1] == Approx(4.0 / std::cos(2.5 * std::numbers::pi / 180.0)));
    CHECK(ranges.range_m[71] == Approx(ranges.range_m[1]));
    // It spans 14 degrees to either side: three sectors beyond the one ahead.
    for (std::size_t k = 0; k < ranges.range_m.size(); ++k) {
        INFO(k);
        CHECK(std::isnan(ranges.range_m[k]) == (k > 3 && k < 69));
    }
    REQUIRE(sweep.sweep(facing(std::numbers::pi / 2, {100'000'000}), ranges));  // to the north
    CHECK(ranges.range_m[18] == Approx(4.0));                                   // 90 degrees clockwise
    CHECK(std::isnan(ranges.range_m[0]));
    CHECK(std::isnan(ranges.range_m[54]));
    CHECK(ranges.stamp.ns == 100'000'000);
    CHECK(ranges.max_range_m == 10.0);
}

TEST_CASE("sweeps come at the chosen rate, and only what is near enough in height and distance counts") {
    ObstacleSweep sweep({.max_range_m = 3.0});
    sweep.update(*wall());
    ObstacleRanges ranges;
    int sweeps = 0;
    for (int i = 0; i < 20; ++i) {
        sweeps += sweep.sweep(facing(0.0, {i * 50'000'000}), ranges) ? 1 : 0;
    }
    CHECK(sweeps == 10);
    CHECK(std::isnan(ranges.range_m[0]));
    ObstacleSweep above({.below_m = 0.0, .above_m = 0.2});
    above.update(*wall());
    Estimate high = facing(0.0, {0});
    high.state.p_W_B.z() = 1.5;
    REQUIRE(above.sweep(high, ranges));
    CHECK(std::isnan(ranges.range_m[0]));
}

}  // namespace
}  // namespace facet
