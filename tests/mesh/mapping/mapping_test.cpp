// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/mapping/mapping.h"

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "tests/support/allocation_guard.h"
#include "tests/support/still_vehicle.h"

namespace facet::mapping_test {
namespace {

constexpr double kFrame_s = 0.05;

/// Feeds samples up to a frame and a little beyond, and gives the frame.
class Feed {
public:
    Feed(const test::StillVehicle& vehicle, Mapping& mapping) : vehicle_(vehicle), mapping_(mapping) {}

    Status give(const StereoFrame& frame, Estimate& estimate) {
        for (; 0.005 * sample_ <= (frame.stamp - test::at(0.0)).seconds() + 0.05; ++sample_) {
            static_cast<void>(mapping_.add_imu({test::at(0.005 * sample_), {0.001, -0.002, 0.003}, {0.0, 0.0, 9.81}}));
        }
        const Status status = mapping_.add_frame(frame, estimate);
        meshes_ += mapping_.finish_frame(frame, estimate) ? 1 : 0;
        return status;
    }
    Status give(int k, Estimate& estimate) { return give(vehicle_.frame(0.1 + kFrame_s * k), estimate); }
    int meshes() const { return meshes_; }

private:
    const test::StillVehicle& vehicle_;
    Mapping& mapping_;
    int sample_ = 0;
    int meshes_ = 0;
};

}  // namespace

TEST_CASE("frames that are refused are never TRACKING: DEGRADED at first, then LOST", "[mapping]") {
    const test::StillVehicle vehicle;
    const auto mapping = std::make_unique<Mapping>();
    REQUIRE(ok(mapping->configure({}, vehicle.rig)));
    Feed feed(vehicle, *mapping);
    Estimate estimate;
    for (int k = 0; k < 4; ++k) {
        REQUIRE(ok(feed.give(k, estimate)));
    }
    REQUIRE(estimate.health.state == TrackingState::kTracking);
    const double lost_after_s = MappingConfig{}.health.lost_after_s;
    for (int k = 0; kFrame_s * k < lost_after_s + 0.5; ++k) {
        const StereoFrame frame = vehicle.frame(-900.0 + kFrame_s * k);
        REQUIRE(mapping->add_frame(frame, estimate) == Status::kOutOfOrder);
        CHECK_FALSE(mapping->finish_frame(frame, estimate));
        CHECK(estimate.stamp == frame.stamp);
        const bool is_long = kFrame_s * k > lost_after_s + 1e-6;
        CHECK(estimate.health.state == (is_long ? TrackingState::kLost : TrackingState::kDegraded));
        CHECK((estimate.health.quality == 0) == is_long);
    }
}

TEST_CASE("a wall gives a mesh, a plane that the estimator holds, and free space before it", "[mapping]") {
    const test::StillVehicle vehicle;
    MappingConfig config;
    config.regularity.mode = RegularityMode::kSpr;
    const auto mapping = std::make_unique<Mapping>();
    REQUIRE(ok(mapping->configure(config, vehicle.rig)));
    mapping->keep_grid();
    Feed feed(vehicle, *mapping);
    Estimate estimate;
    for (int k = 0; k < 120; ++k) {
        REQUIRE(ok(feed.give(k, estimate)));
    }
    CHECK(feed.meshes() > 2);
    CHECK(mapping->mesher().mesh().face_count() > 100);
    REQUIRE(mapping->planes().planes().size() == 1);
    CHECK(mapping->keyframe_view().planes.size() == 1);
    CHECK(mapping->keyframe().estimate_stamp <= estimate.stamp);
    const PlaneFit claim = mapping->claim_of(mapping->planes().planes()[0]);
    CHECK(claim.sigma_m >= mapping->planes().planes()[0].fit.sigma_m);
    REQUIRE(mapping->grid() != nullptr);
    const Eigen::Vector3d ahead_W = estimate.state.q_W_B * vehicle.rig.T_B_C0.q * Eigen::Vector3d::UnitZ();
    CHECK(mapping->grid()->at(estimate.state.p_W_B + 1.5 * ahead_W).space == Space::kFree);
}

TEST_CASE("configured once more it starts over, to the same results", "[mapping]") {
    const test::StillVehicle vehicle;
    const auto mapping = std::make_unique<Mapping>();
    std::vector<Eigen::Vector3d> places[2];
    int faces[2] = {};
    for (const int round : {0, 1}) {
        REQUIRE(ok(mapping->configure({}, vehicle.rig)));
        Feed feed(vehicle, *mapping);
        Estimate estimate;
        for (int k = 0; k < 40; ++k) {
            REQUIRE(ok(feed.give(k, estimate)));
            places[round].push_back(estimate.state.p_W_B);
        }
        CHECK(estimate.health.reset_counter == 0);
        faces[round] = mapping->mesher().mesh().face_count();
    }
    CHECK(places[0] == places[1]);
    CHECK(faces[0] == faces[1]);
}

TEST_CASE("nothing is allocated once it is configured", "[mapping]") {
    const test::StillVehicle vehicle;
    const auto mapping = std::make_unique<Mapping>();
    REQUIRE(ok(mapping->configure({}, vehicle.rig)));
    mapping->keep_grid();
    Feed feed(vehicle, *mapping);
    Estimate estimate;
    const test::AllocationGuard guard;
    bool is_fine = true;
    for (int k = 0; k < 30; ++k) {
        is_fine = ok(feed.give(k, estimate)) && is_fine;
    }
    const auto allocations = guard.allocations();
    CHECK(allocations == 0);
    CHECK(is_fine);
}

TEST_CASE("parameters and rigs out of range are refused", "[mapping]") {
    const test::StillVehicle vehicle;
    const auto mapping = std::make_unique<Mapping>();
    MappingConfig config;
    config.grid.cell_m = -1.0;
    CHECK(mapping->configure(config, vehicle.rig) == Status::kInvalidArgument);
}

}  // namespace facet::mapping_test
