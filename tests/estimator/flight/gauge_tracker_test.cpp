// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/gauge_tracker.h"

#include <catch2/catch.hpp>

namespace facet::gauge_tracker_test {
namespace {

Timestamp at_ms(std::int64_t ms) { return Timestamp{ms * 1'000'000}; }

NavState flying() {
    NavState state;
    state.v_W_B = {2.0, 0.0, 0.0};
    return state;
}

const Eigen::Vector3d kTurning_B{0.0, 0.0, 0.5};
constexpr SlipEvidence kHigh{true, false, Timestamp{200'000'000}, 0.1};
constexpr SlipEvidence kFine{false, false, Timestamp{300'000'000}, 0.1};

double place_sigma(const GaugeTracker& tracker) { return std::sqrt(tracker.gauge().covariance(1, 1)); }

}  // namespace

TEST_CASE("high residuals widen position and yaw by the way flown and the angle turned", "[gauge_tracker]") {
    GaugeTracker tracker;
    CHECK(tracker.step(kHigh, flying(), kTurning_B));
    CHECK(tracker.step(kHigh, flying(), kTurning_B));
    CHECK(place_sigma(tracker) == Approx(0.4));
    CHECK(std::sqrt(tracker.gauge().covariance(0, 0)) == Approx(0.1));
    CHECK(tracker.drift().covariance.isZero(0.0));
}

TEST_CASE(
    "a frame that agrees with a map of earlier keyframes takes the widening back; a keyframe in between forbids it",
    "[gauge_tracker]") {
    const bool with_keyframe = GENERATE(false, true);
    const Timestamp newest = GENERATE(at_ms(0), at_ms(100));  // a keyframe before it may enter the map meanwhile
    GaugeTracker tracker;
    tracker.note_comparison(at_ms(0));
    tracker.step({true, with_keyframe, at_ms(200), 0.1}, flying(), kTurning_B);
    tracker.begin_frame();
    tracker.note_comparison(newest);
    CHECK(tracker.step(kFine, flying(), kTurning_B) == !with_keyframe);
    CHECK(place_sigma(tracker) == Approx(with_keyframe ? 0.2 : 0.0).margin(1e-12));
}

TEST_CASE("a frame that was compared with a map of later keyframes, or none, takes nothing back", "[gauge_tracker]") {
    const bool is_compared = GENERATE(false, true);
    GaugeTracker tracker;
    tracker.note_comparison(at_ms(0));
    tracker.step(kHigh, flying(), kTurning_B);
    tracker.begin_frame();
    if (is_compared) {
        tracker.note_comparison(at_ms(500));
    }
    CHECK_FALSE(tracker.step(kFine, flying(), kTurning_B));
    CHECK(place_sigma(tracker) == Approx(0.2));
}

TEST_CASE("a share of the way that images corrected after an outage stays uncertain", "[gauge_tracker]") {
    GaugeTracker tracker;
    tracker.follow(true, {1.0, 0.0, 0.0});
    tracker.follow(true, {1.0, 0.0, 0.0});
    tracker.add_leap(Eigen::Vector3d::Zero());
    CHECK(place_sigma(tracker) == Approx(0.6));
    tracker.follow(false, {5.0, 0.0, 0.0});
    tracker.add_leap(Eigen::Vector3d::Zero());
    CHECK(place_sigma(tracker) == Approx(0.6));
}

TEST_CASE("a window that ends leaves its position and yaw to the gauge", "[gauge_tracker]") {
    Belief belief;
    belief.covariance.diagonal().segment<3>(kPos).setConstant(0.04);
    GaugeTracker tracker;
    tracker.absorb(belief);
    CHECK(place_sigma(tracker) == Approx(0.2));
    CHECK(tracker.drift().covariance(1, 1) == Approx(0.04));
}

}  // namespace facet::gauge_tracker_test
