// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/phase.h"

#include <catch2/catch.hpp>

namespace facet::phase_test {
namespace {

/// A keyframe in normal flight.
FrameEvidence keyframe() {
    FrameEvidence e;
    e.is_keyframe = true;
    e.stereo = 100;
    return e;
}

}  // namespace

TEST_CASE("a window exists from the first start on", "[phase]") {
    STATIC_REQUIRE_FALSE(has_window(Phase::kEmpty));
    STATIC_REQUIRE_FALSE(has_window(Phase::kWaiting));
    STATIC_REQUIRE(has_window(Phase::kFollowing));
    STATIC_REQUIRE(has_window(Phase::kHolding));
    STATIC_REQUIRE(has_window(Phase::kCoasting));
}

TEST_CASE("a keyframe goes into the window unless it must begin a new one", "[phase]") {
    CHECK(decide(keyframe()) == FrameAction::kTakeKeyframe);
    FrameEvidence held = keyframe();
    held.phase = Phase::kHolding;
    CHECK(decide(held) == FrameAction::kTakeKeyframe);
    FrameEvidence lost = keyframe();
    lost.must_restart = true;
    CHECK(decide(lost) == FrameAction::kRestart);
}

TEST_CASE("a new window waits for enough stereo matches", "[phase]") {
    FrameEvidence lost = keyframe();
    lost.must_restart = true;
    lost.stereo = 19;
    // The old window is still there and takes what there is.
    CHECK(decide(lost) == FrameAction::kTakeKeyframe);
    lost.phase = Phase::kCoasting;
    // Without inertial data since its newest keyframe it cannot.
    CHECK(decide(lost) == FrameAction::kCarryOn);
    lost.stereo = 20;
    CHECK(decide(lost) == FrameAction::kRestart);
}

TEST_CASE("where there is one camera only, its features suffice for a new window", "[phase]") {
    FrameEvidence lost = keyframe();
    lost.must_restart = true;
    lost.phase = Phase::kCoasting;
    lost.stereo = 0;
    lost.lone_features = 19;
    CHECK(decide(lost) == FrameAction::kCarryOn);
    lost.lone_features = 20;
    CHECK(decide(lost) == FrameAction::kRestart);
}

TEST_CASE("a vehicle that stands by both senses is held where it was", "[phase]") {
    FrameEvidence e;
    e.rests = e.image_is_still = true;
    CHECK(decide(e) == FrameAction::kHold);
    e.image_is_still = false;
    CHECK(decide(e) == FrameAction::kCarryOn);
    e.image_is_still = true;
    e.rests = false;
    CHECK(decide(e) == FrameAction::kCarryOn);
    e.rests = true;
    e.phase = Phase::kCoasting;
    CHECK(decide(e) == FrameAction::kCarryOn);
}

TEST_CASE("a frame is requested as keyframe when inertial data do not carry", "[phase]") {
    CHECK_FALSE(wants_keyframe({}));
    PredictionEvidence e;
    e.inertial_data_poor = true;
    CHECK(wants_keyframe(e));
    CHECK_FALSE(must_restart(e));
    for (int reason = 0; reason < 3; ++reason) {
        PredictionEvidence restart;
        restart.is_beyond_recovery = reason == 0;
        restart.reset_wanted = reason == 1;
        restart.phase = reason == 2 ? Phase::kCoasting : Phase::kFollowing;
        CHECK(must_restart(restart));
        CHECK(wants_keyframe(restart));
    }
}

TEST_CASE("a lost window wants keyframes as fast as a start, and restarts after a long gap only", "[phase]") {
    PredictionEvidence e;
    e.is_lost = true;
    e.keyframe_age_s = 0.05;
    CHECK_FALSE(wants_keyframe(e));
    e.keyframe_age_s = 0.1;
    CHECK(wants_keyframe(e));
    CHECK_FALSE(must_restart(e));
    e.keyframe_age_s = 9.0;
    CHECK_FALSE(must_restart(e));
    e.keyframe_age_s = 11.0;
    CHECK(must_restart(e));
    e.is_lost = false;
    CHECK_FALSE(must_restart(e));
}

TEST_CASE("readings in doubt are compared at keyframes that follow each other fast", "[phase]") {
    PredictionEvidence e;
    e.keyframe_age_s = 0.15;
    CHECK_FALSE(wants_keyframe(e));
    e.is_replaced = true;
    CHECK(wants_keyframe(e));
    CHECK_FALSE(must_restart(e));
    e.keyframe_age_s = 0.1;  // places tell next to nothing of a force
    CHECK_FALSE(wants_keyframe(e));
}

TEST_CASE("the end of a rest wants a keyframe if the last one is old", "[phase]") {
    PredictionEvidence e;
    e.phase = Phase::kHolding;
    e.keyframe_age_s = 0.6;
    CHECK(wants_keyframe(e));
    e.rests = true;
    CHECK_FALSE(wants_keyframe(e));
    e.rests = false;
    e.keyframe_age_s = 0.4;
    CHECK_FALSE(wants_keyframe(e));
}

}  // namespace facet::phase_test
