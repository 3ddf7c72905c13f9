// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/obstacle_sweep.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>

namespace facet::obstacle_sweep_test {
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
    REQUIRE(sweep.sweep(facing(0.0, {0}), nullptr, ranges));
    CHECK(ranges.range_m[0] == Approx(4.0));
    CHECK(ranges.range_m[1] == Approx(4.0 / std::cos(2.5 * std::numbers::pi / 180.0)));
    CHECK(ranges.range_m[71] == Approx(ranges.range_m[1]));
    // It spans 14 degrees to either side: three sectors beyond the one ahead.
    for (std::size_t k = 0; k < ranges.range_m.size(); ++k) {
        INFO(k);
        CHECK(std::isnan(ranges.range_m[k]) == (k > 3 && k < 69));
    }
    REQUIRE(sweep.sweep(facing(std::numbers::pi / 2, {100'000'000}), nullptr, ranges));  // to the north
    CHECK(ranges.range_m[18] == Approx(4.0));                                            // 90 degrees clockwise
    CHECK(std::isnan(ranges.range_m[0]));
    CHECK(std::isnan(ranges.range_m[54]));
    CHECK(ranges.stamp.ns == 100'000'000);
    CHECK(ranges.max_range_m == 6.0);
}

TEST_CASE("sectors count from the reported body, which may sit elsewhere and be turned") {
    const Se3 T_body_imu{Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ())),
                         {0.0, 0.0, 0.0}};
    // The IMU looks north in the body, so the body looks to the IMU's right, and a metre ahead of it.
    ObstacleSweep sweep({}, Se3{Eigen::Quaterniond::Identity(), {-1.0, 0.0, 0.0}} * T_body_imu);
    sweep.update(*wall());
    ObstacleRanges ranges;
    REQUIRE(sweep.sweep(facing(std::numbers::pi / 2, {0}), nullptr, ranges));
    CHECK(ranges.range_m[0] == Approx(3.0));
    CHECK(std::isnan(ranges.range_m[18]));
}

TEST_CASE("sweeps come at the chosen rate, and only what is near enough in height and distance counts") {
    ObstacleSweep sweep({.max_range_m = 3.0});
    sweep.update(*wall());
    ObstacleRanges ranges;
    int sweeps = 0;
    for (int i = 0; i < 20; ++i) {
        sweeps += sweep.sweep(facing(0.0, {i * 50'000'000}), nullptr, ranges) ? 1 : 0;
    }
    CHECK(sweeps == 10);
    CHECK(std::isnan(ranges.range_m[0]));
    ObstacleSweep above({.below_m = 0.0, .above_m = 0.2});
    above.update(*wall());
    Estimate high = facing(0.0, {0});
    high.state.p_W_B.z() = 1.5;
    REQUIRE(above.sweep(high, nullptr, ranges));
    CHECK(std::isnan(ranges.range_m[0]));
}

/// A grid in which the vehicle has flown from the origin 6 m east, and which has seen a wall there, 2 m to the north.
std::unique_ptr<OccupancyGrid> corridor() {
    auto grid = std::make_unique<OccupancyGrid>();
    HorizonMesh mesh;
    const std::array<VertexSlot, 3> slots{mesh.add_vertex(LandmarkId(1)).value(),
                                          mesh.add_vertex(LandmarkId(2)).value(),
                                          mesh.add_vertex(LandmarkId(3)).value()};
    mesh.vertex(slots[0]).measured_W = {-1.0, 2.05, -1.0};
    mesh.vertex(slots[1]).measured_W = {1.0, 2.05, -1.0};
    mesh.vertex(slots[2]).measured_W = {0.0, 2.05, 1.0};
    mesh.face(mesh.add_face(slots).value()).last_confirmed = 1;
    KeyframeView view;
    for (int k = 0; k <= 14; ++k) {
        view.stamp = {250'000'000LL * k};
        view.T_W_C0.p = {7.0 - 0.5 * k, 0.0, 0.0};
        grid->update(view, mesh, k == 14 ? 1U : 2U);
    }
    return grid;
}

TEST_CASE("with a grid a sector is an obstacle, free or unknown, and old faces do not stand in free space") {
    const auto grid = corridor();
    ObstacleSweep sweep({.max_range_m = 5.0, .below_m = 0.2, .above_m = 0.2});
    ObstacleRanges ranges;
    REQUIRE(sweep.sweep(facing(0.0, {0}), grid.get(), ranges));
    CHECK(std::isinf(ranges.range_m[0]));                     // flown along
    CHECK(ranges.range_m[54] == Approx(2.05F).margin(0.11));  // the wall, to the left
    CHECK(std::isnan(ranges.range_m[18]));                    // nobody has looked to the right
    sweep.update(*wall());                                    // 4 m east, where the vehicle has flown since
    REQUIRE(sweep.sweep(facing(0.0, {1'000'000'000}), grid.get(), ranges));
    CHECK(std::isinf(ranges.range_m[0]));
}

}  // namespace
}  // namespace facet::obstacle_sweep_test
