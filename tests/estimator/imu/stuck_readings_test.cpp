// SPDX-License-Identifier: BSD-2-Clause
// A sensor that hangs is told from one that is coarse, or that lives in a world without noise.
#include "estimator/imu/stuck_readings.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

namespace facet::stuck_readings_test {
namespace {

constexpr ImuAxisMask kNone = 0;

/// Readings that differ each time, but where told otherwise.
struct Sensor {
    explicit Sensor(double rate_hz = 200.0) : stuck(rate_hz) {}

    /// The next n samples. @return what is found stuck at the last one
    ImuAxisMask give(int n, bool gyro_lives, bool accel_lives, ImuAxisMask clipped = kNone) {
        ImuAxisMask found = kNone;
        for (int k = 0; k < n; ++k) {
            ++count;
            sample.stamp.ns += 5'000'000;
            sample.w_B.y() += gyro_lives ? 1e-6 : 0.0;
            sample.a_B.z() += accel_lives ? 1e-6 : 0.0;
            found = stuck.add(sample, clipped);
        }
        return found;
    }

    StuckReadings stuck;
    ImuSample sample;
    int count = 0;
};

}  // namespace

TEST_CASE("a sensor that repeats its readings is stuck from the twentieth repeat on", "[stuck]") {
    Sensor sensor;
    CHECK(sensor.give(100, true, true) == kNone);
    CHECK(sensor.give(19, true, false) == kNone);
    CHECK(sensor.give(1, true, false) == kAccelAxes);
    CHECK(sensor.give(500, true, false) == kAccelAxes);
    CHECK(sensor.give(1, true, true) == kNone);
    CHECK(sensor.give(20, false, true) == kGyroAxes);
}

TEST_CASE("one axis that lives is enough, and a clipped one has another reason", "[stuck]") {
    Sensor sensor;
    sensor.give(10, true, true);
    for (int k = 0; k < 100; ++k) {  // only z changes
        REQUIRE(sensor.give(1, false, true) == (k < 19 ? kNone : kGyroAxes));
    }
    sensor.give(1, true, true);
    CHECK(sensor.give(100, false, false, 0x01) == kAccelAxes);
    CHECK(sensor.give(100, false, false, 0x09) == kNone);
}

TEST_CASE("at a high rate a run is long enough by its time", "[stuck]") {
    Sensor sensor(1000.0);
    sensor.give(1, true, true);
    CHECK(sensor.give(49, true, false) == kNone);
    CHECK(sensor.give(1, true, false) == kAccelAxes);
}

TEST_CASE("runs that a sensor has shown while it was believed are its habit, four times as long is not", "[stuck]") {
    Sensor sensor;
    for (int k = 0; k < 50; ++k) {  // each reading ten times
        CHECK(sensor.give(9, false, false) == kNone);
        CHECK(sensor.give(1, true, true) == kNone);
    }
    CHECK(sensor.give(35, false, false) == kNone);
    CHECK(sensor.give(1, false, false) == (kGyroAxes | kAccelAxes));
    sensor.give(364, false, false);  // at rest without noise for two seconds, and nobody had a doubt
    sensor.give(1, true, true);
    CHECK(sensor.give(1599, false, false) == kNone);
    CHECK(sensor.give(1, false, false) == (kGyroAxes | kAccelAxes));
}

TEST_CASE("runs that were doubted are no habit", "[stuck]") {
    Sensor sensor;
    sensor.give(10, true, true);
    REQUIRE(sensor.give(400, true, false) == kAccelAxes);
    sensor.stuck.distrust(kAccelAxes);
    sensor.give(10, true, true);
    REQUIRE(sensor.give(20, true, false) == kAccelAxes);
    sensor.stuck.distrust(kAccelAxes);
    sensor.stuck.distrust(kNone);  // taken back
    sensor.give(10, true, true);
    CHECK(sensor.give(79, true, false) == kNone);
    CHECK(sensor.give(1, true, false) == kAccelAxes);
}

TEST_CASE("nothing is known of the sample after a restart, and habits stay", "[stuck]") {
    Sensor sensor;
    sensor.give(10, true, true);
    sensor.give(10, false, false);
    sensor.give(1, true, true);
    sensor.give(30, false, false);
    sensor.stuck.restart();
    CHECK(sensor.give(40, false, false) == kNone);
    CHECK(sensor.give(1, false, false) == (kGyroAxes | kAccelAxes));
}

}  // namespace facet::stuck_readings_test
