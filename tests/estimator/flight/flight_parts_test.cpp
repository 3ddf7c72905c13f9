// SPDX-License-Identifier: BSD-2-Clause
// The small parts of a flight that judge one thing each.
#include <catch2/catch.hpp>
#include <cmath>

#include "estimator/flight/clock_watch.h"
#include "estimator/flight/delay_correction.h"
#include "estimator/flight/emitter_watch.h"
#include "estimator/flight/reset_counter.h"
#include "estimator/flight/stereo_evidence.h"

namespace facet::flight_parts_test {
namespace {

Timestamp at_ms(std::int64_t ms) { return Timestamp{ms * 1'000'000}; }

}  // namespace

TEST_CASE("images of a pair contradict readings only if the map's keyframe matched as well", "[stereo_evidence]") {
    StereoEvidence stereo;
    stereo.step(true, 3, 8);
    CHECK(stereo.is_unmatched());
    CHECK_FALSE(stereo.is_independent());
    stereo.step(true, 50, 8);
    CHECK_FALSE(stereo.is_independent());  // compared with the map of the keyframe before
    stereo.step(false, 0, 8);
    CHECK(stereo.is_independent());
    stereo.support(true, true);
    CHECK(stereo.has_supported());
    stereo.step(true, 0, 8);
    stereo.support(true, true);
    CHECK(stereo.has_supported());  // for as long as the suspicion lasts
    stereo.support(false, false);
    CHECK_FALSE(stereo.has_supported());
}

TEST_CASE("frames lit by an alternating emitter are left out, a lost frame included", "[emitter_watch]") {
    EmitterWatch emitter;
    int left_out = 0;
    for (int k = 0; k < 60; ++k) {
        const bool is_lit = k % 2 == 1;
        if (k == 30 || k == 41) {  // one of either kind is lost on the way
            continue;
        }
        const bool leaves_out = emitter.step((is_lit ? 0.12 : 0.08) * (1.0 + 0.01 * (k % 5)));
        CHECK((!leaves_out || is_lit));
        CHECK((leaves_out == is_lit || k < 10));
        left_out += leaves_out ? 1 : 0;
    }
    CHECK(left_out > 20);
    CHECK(emitter.is_alternating());
    for (int k = 0; k < 20; ++k) {  // it is switched off
        const bool leaves_out = emitter.step(0.08);
        CHECK_FALSE((leaves_out && k > 0));
    }
    CHECK_FALSE(emitter.is_alternating());
}

TEST_CASE("motion, a passing bright object and dark images are no emitter", "[emitter_watch]") {
    EmitterWatch emitter;
    for (int k = 0; k < 200; ++k) {
        const double motion = 0.08 * std::exp(0.05 * std::sin(2.1 * k) + (k > 80 && k < 120 ? 0.8 : 0.0));
        CHECK_FALSE(emitter.step(k % 17 == 0 ? 0.0 : motion));
    }
    CHECK_FALSE(emitter.is_alternating());
}

TEST_CASE("a delay is accepted once, if it is large and certain", "[delay_correction]") {
    DelayCorrection delay;
    CHECK_FALSE(delay.accept(0.0));
    CHECK_FALSE(delay.propose({0.007, 1e-4}, 0.0));
    CHECK_FALSE(delay.propose({0.02, 0.005}, 0.0));
    CHECK_FALSE(delay.accept(0.0));
    CHECK(delay.propose({-0.04, 0.002}, 0.01));
    CHECK(delay.found_s() == 0.0);  // until it is accepted
    CHECK(delay.accept(0.01).value_or(0.0) == Approx(-0.04));
    CHECK(delay.found_s() == Approx(-0.03));
    CHECK_FALSE(delay.accept(-0.03));
}

TEST_CASE("turns between images are asked for the delay where depths are known, and it is in question",
          "[delay_correction]") {
    DelayCorrection delay;
    CHECK(delay.is_open(0.0, 0.005, false, true));
    CHECK(delay.is_open(0.02, 0.005, true, true));
    CHECK_FALSE(delay.is_open(0.0, 0.005, true, true));
    CHECK_FALSE(delay.is_open(0.0, 0.005, false, false));  // one camera, which is never TRACKING
    CHECK_FALSE(delay.is_open(0.02, 0.005, false, false));
}

namespace {

/// A lively turn and its samples, of which images show what was `late_s` before, up to now.
struct LateTurns {
    explicit LateTurns(double late_s) : late_s(late_s) {
        imu.clear(200.0, {});
        delay.configure(2e-4);
    }
    static double angle(double t_s) { return 0.1 * std::sin(4.0 * t_s) + 0.05 * std::cos(9.0 * t_s); }
    static Timestamp at(double t_s) { return Timestamp{1'000'000'000} + Duration::from_seconds(t_s); }
    /// @return whether the delay is in doubt
    bool fly(double until_s, double believed_s, bool is_unknown) {
        for (; now_s + 0.05 < until_s; now_s += 0.05) {
            for (; sample <= std::lround(200.0 * (now_s + 0.05)); ++sample) {
                const double rate = (angle(sample / 200.0 + 1e-4) - angle(sample / 200.0 - 1e-4)) / 2e-4;
                REQUIRE(ok(imu.push({at(sample / 200.0), {0.01, 0.02, rate}, {0.0, 0.0, 9.81}})));
            }
            if (now_s > 0.24) {
                const double turn = angle(now_s + 0.05 - late_s) - angle(now_s - late_s);
                delay.add(at(now_s), at(now_s + 0.05), {0.0, 0.0, turn + wrong_rad * (++count % 3)});
                delay.step(imu, believed_s, 0.0, at(now_s + 0.05), is_unknown);
            }
        }
        return delay.is_in_doubt();
    }
    double late_s;
    double wrong_rad = 0.0;
    int count = 0;
    int sample = 0;
    double now_s = 0.0;
    ImuBuffer imu;
    DelayCorrection delay;
};

}  // namespace

TEST_CASE("a start waits while turns contradict the delay, which then is found", "[delay_correction]") {
    const double late_s = GENERATE(0.05, -0.03, 0.025);
    CAPTURE(late_s);
    LateTurns flight(late_s);
    CHECK(flight.fly(0.48, 0.0, true));  // four turns
    CHECK(flight.fly(0.83, 0.0, true));
    REQUIRE(flight.delay.accept(0.0));
    CHECK(flight.delay.found_s() == Approx(-late_s).margin(4e-3));
    CHECK_FALSE(flight.delay.is_in_doubt());
    CHECK_FALSE(flight.fly(1.5, flight.delay.found_s(), true));
    CHECK_FALSE(flight.delay.accept(0.0));
}

TEST_CASE("a start waits neither for a delay that is right nor for turns that no delay explains",
          "[delay_correction]") {
    LateTurns right(0.003);
    for (double until_s = 0.3; until_s < 2.0; until_s += 0.05) {
        CHECK_FALSE(right.fly(until_s, 0.0, true));
    }
    LateTurns wrong(0.0);
    wrong.wrong_rad = 3e-3;
    CHECK(wrong.fly(0.48, 0.0, true));
    CHECK_FALSE(wrong.fly(1.6, 0.0, true));
    CHECK_FALSE(wrong.delay.accept(0.0));
}

TEST_CASE("once an estimate has been given, a second's turns have to show another delay", "[delay_correction]") {
    LateTurns flight(0.05);
    flight.fly(1.18, 0.0, false);
    CHECK_FALSE(flight.delay.is_in_doubt());
    flight.fly(1.6, 0.0, false);
    CHECK(flight.delay.accept(0.0));
}

TEST_CASE("the reset counter rises once for somebody who has been given an estimate", "[reset_counter]") {
    ResetCounter resets;
    resets.jump();
    CHECK(resets.value() == 0);
    CHECK(resets.is_first_start());
    resets.give();
    resets.jump();
    resets.jump();
    CHECK(resets.value() == 1);
    CHECK_FALSE(resets.is_first_start());
}

TEST_CASE("refused samples that go on as a clock does, with frames on it, are a new clock", "[clock_watch]") {
    const bool has_frames = GENERATE(false, true);
    ClockWatch clocks;
    for (int k = 0; k <= 60; ++k) {
        clocks.refuse_sample(at_ms(1000 + 10 * k));
    }
    clocks.offer(at_ms(has_frames ? 1500 : 9000));
    CHECK(clocks.is_new_clock(at_ms(9000)) == has_frames);
    CHECK_FALSE(clocks.is_new_clock(at_ms(2000)));  // behind by little: it catches up
    CHECK(clocks.time_on_new_clock_s(at_ms(1400)) == Approx(has_frames ? 0.6 : 7.6));
}

TEST_CASE("time without samples counts from a tenth of a second, and is handed over once", "[clock_watch]") {
    ClockWatch clocks;
    for (int k = 0; k < 8; ++k) {
        clocks.refuse_sample(at_ms(10 * k));
    }
    CHECK(clocks.take_time_without_samples_s() == 0.0);
    for (int k = 0; k <= 30; ++k) {
        clocks.refuse_sample(at_ms(10 * k));
    }
    const double lost_s = clocks.take_time_without_samples_s();
    CHECK(lost_s == Approx(0.3));
    CHECK(clocks.take_time_without_samples_s() == 0.0);
    clocks.lose(lost_s);
    CHECK(clocks.take_lost_s() == Approx(0.3));
    CHECK(clocks.take_lost_s() == 0.0);
}

TEST_CASE("frames that come late are waited for, up to a second", "[frame_times]") {
    FrameTimes frames;
    CHECK(frames.carry_until(at_ms(1000)) == at_ms(800));
    frames.expect_late(Duration::from_seconds(0.3));
    CHECK(frames.carry_until(at_ms(1000)) == at_ms(600));
    frames.expect_late(Duration::from_seconds(0.1));
    CHECK(frames.carry_until(at_ms(1000)) == at_ms(600));
    frames.expect_late(Duration::from_seconds(5.0));
    CHECK(frames.carry_until(at_ms(2000)) == at_ms(1000));
    frames.last_frame = at_ms(1000);
    CHECK_FALSE(frames.are_missing(at_ms(1400)));
    CHECK(frames.are_missing(at_ms(1600)));
}

}  // namespace facet::flight_parts_test
