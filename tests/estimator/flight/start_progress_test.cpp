// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/start_progress.h"

#include <catch2/catch.hpp>

namespace facet::start_progress_test {
namespace {

Timestamp at_ms(std::int64_t ms) { return Timestamp{ms * 1'000'000}; }

StillnessEvidence images_of(double disparity_px) { return {true, true, 40, disparity_px, 0.5}; }

StartProgress begun(bool is_still) {
    StartProgress start;
    start.begin_window(at_ms(0), true, false);
    start.begin_first(is_still);
    return start;
}

}  // namespace

TEST_CASE("a start as at rest is open until images agree, and settled after 0.3 s of them", "[start_progress]") {
    StartProgress start = begun(true);
    CHECK(start.is_open());
    start.judge_claim(images_of(0.1), true, at_ms(50));
    CHECK(start.claim() == RestClaim::kSeen);
    CHECK_FALSE(start.is_open());
    CHECK_FALSE(start.forces_keyframes());
    start.judge_claim(images_of(0.1), true, at_ms(300));
    CHECK(start.claim() == RestClaim::kNone);
    CHECK(start.forces_keyframes());                     // for a window that holds the place
    CHECK_FALSE(start.can_judge_claim(images_of(3.0)));  // a smooth take-off later refutes nothing
}

TEST_CASE("images that move refute a rest; one that the samples drop does not count", "[start_progress]") {
    StartProgress start = begun(true);
    start.judge_claim(images_of(3.0), true, at_ms(50));
    CHECK(start.claim() == RestClaim::kRefuted);
    CHECK(start.is_open());
    StartProgress other = begun(true);
    other.judge_claim(images_of(3.0), false, at_ms(50));
    CHECK(other.claim() == RestClaim::kNone);
    CHECK_FALSE(other.forces_keyframes());
}

TEST_CASE("images that cannot be tracked, or too few tracks, do not judge a rest", "[start_progress]") {
    const StartProgress start = begun(true);
    StillnessEvidence e = images_of(3.0);
    CHECK(start.can_judge_claim(e));
    e.tracked = 7;
    CHECK_FALSE(start.can_judge_claim(e));
    e = images_of(3.0);
    e.is_usable = false;
    CHECK_FALSE(start.can_judge_claim(e));
}

TEST_CASE("a start in motion may stand while images are still, and forces keyframes once it does", "[start_progress]") {
    StartProgress start = begun(false);
    CHECK(start.may_stand());
    CHECK(start.is_open());
    start.judge_stand(images_of(0.2));
    CHECK(start.may_stand());
    CHECK_FALSE(start.stands_long_enough(at_ms(250)));
    CHECK(start.stands_long_enough(at_ms(300)));
    start.end_stand();
    start.begin_shaken_rest();
    for (int k = 0; k < 4; ++k) {
        CHECK(start.forces_keyframes());
        start.count_keyframe();
    }
    CHECK_FALSE(start.forces_keyframes());
    StartProgress moving = begun(false);
    moving.judge_stand(images_of(0.8));
    CHECK_FALSE(moving.may_stand());
}

TEST_CASE("a window without velocity awaits an answer, unless it begins from one", "[start_progress]") {
    StartProgress start;
    start.begin_window(at_ms(0), false, false);
    CHECK(start.awaits_answer());
    CHECK(start.is_open());
    start.begin_window(at_ms(0), false, true);
    CHECK_FALSE(start.awaits_answer());
    CHECK(start.is_open());
    start.confirm();
    CHECK_FALSE(start.is_open());
}

}  // namespace facet::start_progress_test
