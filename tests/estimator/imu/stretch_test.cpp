// SPDX-License-Identifier: BSD-2-Clause
// Statistics of a stretch against closed forms, and what they leave out.
#include "estimator/imu/stretch.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

namespace facet {
namespace {

constexpr std::int64_t kStep_ns = 5'000'000;

Timestamp at_step(int k) { return Timestamp{k * kStep_ns}; }

}  // namespace

TEST_CASE("statistics of a ramp and of white noise") {
    const auto buffer = std::make_unique<ImuBuffer>(200.0);
    std::mt19937 rng(2);
    std::normal_distribution<double> normal;
    for (int k = 0; k <= 400; ++k) {
        REQUIRE(ok(buffer->push({at_step(k), {0.01 * k, 0.0, 0.2 * normal(rng)}, {0.0, 3.0, 0.5 * normal(rng)}})));
    }
    StretchStatistics s;
    REQUIRE(ok(stretch_statistics(*buffer, at_step(0), at_step(400), s)));
    CHECK(s.samples == 400);
    CHECK(s.is_whole);
    CHECK(s.mean_w_B.x() == Approx(2.005));
    CHECK(s.mean_a_B.y() == Approx(3.0));
    CHECK(s.gyro_std.x() == Approx(4.0 / std::sqrt(12.0)).epsilon(0.01));
    CHECK(s.gyro_step_std.x() == Approx(0.01 / std::sqrt(2.0)).epsilon(0.01));
    CHECK(s.gyro_drift.x() == Approx(2.0));
    CHECK(s.gyro_std.z() == Approx(0.2).epsilon(0.1));
    CHECK(s.gyro_step_std.z() == Approx(0.2).epsilon(0.1));
    CHECK(s.accel_step_std.z() == Approx(0.5).epsilon(0.1));
    CHECK(std::abs(s.accel_drift.z()) < 3.0 * s.drift_sigma(0.5));
    CHECK(s.drift_sigma(0.5) == Approx(0.05));
    CHECK(s.drift_share(0.001, 0.001) == Approx(2.0 / (0.001 + 4.0 * 0.1 * s.gyro_step_std.x())));
}

TEST_CASE("gaps and clipped readings are told, too few samples are not ready") {
    const auto buffer = std::make_unique<ImuBuffer>(200.0);
    for (int k = 0; k < 40; ++k) {
        const double force = k == 30 ? 1e3 : 9.81;
        REQUIRE(ok(buffer->push({at_step(k < 20 ? k : k + 10), Eigen::Vector3d::Zero(), {0.0, 0.0, force}})));
    }
    StretchStatistics s;
    REQUIRE(ok(stretch_statistics(*buffer, at_step(0), at_step(19), s)));
    CHECK(s.is_whole);
    REQUIRE(ok(stretch_statistics(*buffer, at_step(10), at_step(35), s)));
    CHECK_FALSE(s.is_whole);
    REQUIRE(ok(stretch_statistics(*buffer, at_step(35), at_step(45), s)));
    CHECK_FALSE(s.is_whole);
    CHECK(stretch_statistics(*buffer, at_step(0), at_step(3), s) == Status::kNotReady);
    CHECK(stretch_statistics(*buffer, at_step(0), at_step(90), s) == Status::kNotReady);
    CHECK(stretch_statistics(*buffer, at_step(9), at_step(3), s) == Status::kInvalidArgument);
}

}  // namespace facet
