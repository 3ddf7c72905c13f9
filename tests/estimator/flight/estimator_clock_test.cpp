// SPDX-License-Identifier: BSD-2-Clause
// Clocks that jump and come back: the estimator begins anew, and single wild stamps are not followed.
#include <algorithm>
#include <cmath>
#include <map>

#include "tests/support/still_vehicle.h"

namespace facet::estimator_clock_test {

using facet::test::at;
using facet::test::StillVehicle;

namespace {

constexpr double kHour_s = 3600.0;

/// A vehicle at rest, each of whose clocks may be off.
struct Flight {
    Flight() {
        REQUIRE(ok(estimator.configure({}, vehicle.rig)));
        fly(2.5);
        REQUIRE(estimate.health.state == TrackingState::kTracking);
    }

    /// Frames at 20 Hz, if wanted, each after the samples up to it. @return seconds of each state seen
    std::map<TrackingState, double> fly(double duration_s) {
        std::map<TrackingState, double> seen;
        for (int k = 0; k < std::lround(duration_s / 0.05); ++k) {
            for (int i = 0; i < 10; ++i) {
                imu(now_s + imu_ahead_s);
                now_s += 0.005;
            }
            Estimate offered;
            offered.stamp.ns = -1;
            if (has_frames) {
                static_cast<void>(estimator.add_frame(vehicle.frame(now_s - 0.01 + frames_ahead_s), offered));
            }
            Estimate carried;
            const bool is_carried = ok(estimator.take_carried(carried));
            estimate = is_carried ? carried : offered.stamp.ns >= 0 ? offered : estimate;
            seen[estimate.health.state] += 0.05;
        }
        return seen;
    }
    void imu(double stamp_s) {
        static_cast<void>(estimator.add_imu({at(stamp_s), {0.001, -0.002, 0.003}, {0.0, 0.0, 9.81}}));
    }
    void check_is_back(const Estimate& before) const {
        CHECK(estimate.health.state == TrackingState::kTracking);
        CHECK(estimate.health.reset_counter == before.health.reset_counter + 1);
        CHECK(estimate.state.p_W_B.norm() < 0.05);
        // Nobody knows where it has been meanwhile.
        CHECK(estimate.covariance(3, 3) > std::pow(1.0, 2));
        CHECK(estimate.covariance(2, 2) > std::pow(0.2, 2));
    }

    StillVehicle vehicle;
    Estimator estimator;
    Estimate estimate;
    double now_s = 10'000.0;
    double imu_ahead_s = 0.0;
    double frames_ahead_s = 0.0;
    bool has_frames = true;
};

}  // namespace

TEST_CASE("an inertial clock that was an hour ahead for a while is followed back", "[estimator_clock]") {
    Flight flight;
    const Estimate before = flight.estimate;
    flight.imu_ahead_s = kHour_s;
    CHECK(flight.fly(2.0)[TrackingState::kLost] > 1.5);
    flight.imu_ahead_s = 0.0;
    CHECK(flight.fly(2.0)[TrackingState::kTracking] > 0.2);
    flight.check_is_back(before);
    CHECK(flight.fly(5.0)[TrackingState::kTracking] == Approx(5.0));
}

TEST_CASE("clocks that go back by an hour together are followed", "[estimator_clock]") {
    Flight flight;
    const Estimate before = flight.estimate;
    flight.imu_ahead_s = flight.frames_ahead_s = -kHour_s;
    CHECK(flight.fly(2.5)[TrackingState::kTracking] > 0.5);
    flight.check_is_back(before);
    CHECK(flight.estimate.stamp < before.stamp);
    CHECK(flight.fly(5.0)[TrackingState::kTracking] == Approx(5.0));
}

TEST_CASE("one stamp an hour ahead costs two seconds, not the flight", "[estimator_clock]") {
    Flight flight;
    const Estimate before = flight.estimate;
    flight.imu(flight.now_s + kHour_s);
    flight.fly(2.5);
    flight.check_is_back(before);
}

TEST_CASE("wild stamps in the past are refused, and change nothing", "[estimator_clock]") {
    Flight flight;
    Flight same;
    for (int k = 0; k < 40; ++k) {
        flight.imu(flight.now_s - kHour_s + 0.7 * k);
        flight.imu(flight.now_s - 1.0);
        flight.fly(0.05);
        same.fly(0.05);
    }
    CHECK(flight.estimate.health.reset_counter == 0);
    CHECK(flight.estimate.state.p_W_B == same.estimate.state.p_W_B);
    CHECK(flight.estimate.health.state == TrackingState::kTracking);
}

TEST_CASE("an inertial clock that goes back alone is not followed: frames are on the old one", "[estimator_clock]") {
    Flight flight;
    flight.imu_ahead_s = -kHour_s;
    flight.fly(1.5);
    flight.imu_ahead_s = 0.0;
    const auto seen = flight.fly(2.0);
    CHECK(seen.at(TrackingState::kTracking) > 1.0);
    CHECK(flight.estimate.health.reset_counter == 1);
    CHECK(flight.estimate.state.p_W_B.norm() < 0.05);
}

TEST_CASE("a clock that is a second behind catches up, in the old history", "[estimator_clock]") {
    Flight flight;
    flight.imu_ahead_s = 1.0;
    flight.fly(2.0);
    flight.imu_ahead_s = 0.0;
    flight.fly(3.0);
    CHECK(flight.estimate.health.state == TrackingState::kTracking);
    CHECK(flight.estimate.state.p_W_B.norm() < 0.05);
    CHECK(flight.estimate.covariance(3, 3) < 0.25);  // followed at once it would be above 1 m
}

TEST_CASE("without frames nothing shows that a clock is right", "[estimator_clock]") {
    Flight flight;
    flight.has_frames = false;
    flight.imu_ahead_s = -kHour_s;
    flight.fly(2.0);
    flight.has_frames = true;
    flight.imu_ahead_s = 0.0;
    flight.fly(2.0);
    CHECK(flight.estimate.health.state == TrackingState::kTracking);
    CHECK(flight.estimate.stamp.seconds() > 10'000.0);
}

}  // namespace facet::estimator_clock_test
