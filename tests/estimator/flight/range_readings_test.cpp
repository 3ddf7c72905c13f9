// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/range_readings.h"

#include <catch2/catch.hpp>
#include <limits>

#include "estimator/geometry/so3.h"

namespace facet::range_readings_test {
namespace {

Timestamp ms(int time) { return {1'000'000'000 + time * 1'000'000LL}; }

RangeReadings with_reading_at(int time, const Eigen::Vector3d& p_B = {0.0, 0.0, -1.5}) {
    RangeReadings readings;
    REQUIRE(ok(readings.push({ms(time), p_B})));
    return readings;
}

const Eigen::Vector3d kNoTurn = Eigen::Vector3d::Zero();

}  // namespace

TEST_CASE("the newest reading before the stamp counts", "[range]") {
    RangeReadings readings;
    for (int i = 0; i < 100; ++i) {  // more than it keeps
        REQUIRE(ok(readings.push({ms(20 * i), {0.0, 0.0, -1.0 - i}})));
    }
    CHECK(readings.ground_B(ms(1899), {}, kNoTurn)->z() == -1.0 - 94);
    CHECK(readings.ground_B(ms(1980), {}, kNoTurn)->z() == -1.0 - 99);
    CHECK_FALSE(readings.ground_B(ms(300), {}, kNoTurn).has_value());
}

TEST_CASE("old readings, none at all, and beams at walls are no readings", "[range]") {
    CHECK_FALSE(RangeReadings{}.ground_B(ms(0), {}, kNoTurn).has_value());
    const RangeReadings readings = with_reading_at(0);
    CHECK(readings.ground_B(ms(99), {}, kNoTurn).has_value());
    CHECK_FALSE(readings.ground_B(ms(101), {}, kNoTurn).has_value());
    NavState tilted;
    tilted.q_W_B = so3_exp({0.0, 0.8, 0.0});
    CHECK_FALSE(readings.ground_B(ms(0), tilted, kNoTurn).has_value());
    tilted.q_W_B = so3_exp({0.0, 0.7, 0.0});
    CHECK(readings.ground_B(ms(0), tilted, kNoTurn).has_value());
}

TEST_CASE("a reading is carried on by velocity and rate", "[range]") {
    // GIVEN a body that climbs at 2 m/s and pitches at 1 rad/s, 50 ms after the reading
    const Eigen::Vector3d w_B(0.0, 1.0, 0.0);
    NavState then;
    then.p_W_B = {0.0, 0.0, 1.5};
    then.q_W_B = so3_exp({0.1, 0.0, 0.2});
    then.v_W_B = {0.5, 0.0, 2.0};
    NavState now = then;
    now.p_W_B += 0.05 * then.v_W_B;
    now.q_W_B = then.q_W_B * so3_exp(0.05 * w_B);
    const Eigen::Vector3d met_B(0.1, 0.0, -1.5);
    // THEN the same point of the ground is meant
    const RangeReadings readings = with_reading_at(0, met_B);
    const auto ground_B = readings.ground_B(ms(50), now, w_B);
    REQUIRE(ground_B.has_value());
    CHECK((now.p_W_B + now.q_W_B * *ground_B - (then.p_W_B + then.q_W_B * met_B)).norm() < 1e-9);
}

TEST_CASE("readings that are not finite or go back in time are refused", "[range]") {
    RangeReadings readings = with_reading_at(10);
    CHECK(readings.push({ms(10), {0.0, 0.0, -1.0}}) == Status::kOutOfOrder);
    CHECK(readings.push({ms(20), {0.0, 0.0, std::numeric_limits<double>::infinity()}}) == Status::kInvalidArgument);
    CHECK(readings.ground_B(ms(30), {}, kNoTurn)->z() == -1.5);
}

TEST_CASE("silence is noticed only after readings", "[range]") {
    CHECK_FALSE(RangeReadings{}.are_missing(ms(5000)));
    CHECK_FALSE(with_reading_at(0).are_missing(ms(900)));
    CHECK(with_reading_at(0).are_missing(ms(1100)));
}

}  // namespace facet::range_readings_test
