// SPDX-License-Identifier: BSD-2-Clause
// Statistics of a stretch against closed forms, and what they leave out.
#include "estimator/imu/stretch.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

namespace facet::stretch_test {
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

TEST_CASE("gaps and clipped readings are reported, too few samples are not ready") {
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

TEST_CASE("a tapered mean leaves nothing of a tone, whatever its phase, and says how sure it is") {
    constexpr double kAmplitude = 0.5;
    for (const double f_hz : {12.5, 17.0, 33.0}) {
        double worst = 0.0;
        double worst_plain = 0.0;
        for (int phase = 0; phase < 8; ++phase) {
            const auto buffer = std::make_unique<ImuBuffer>(200.0);
            for (int k = 0; k <= 60; ++k) {
                const double shake = kAmplitude * std::sin(6.2831853 * f_hz * 0.005 * k + 0.7854 * phase);
                REQUIRE(ok(buffer->push({at_step(k), {0.02, 0.1 * shake, 0.0}, {shake, 0.3, 9.81}})));
            }
            TaperedMeans means;
            StretchStatistics plain;
            REQUIRE(ok(tapered_means(*buffer, at_step(0), at_step(60), means)));
            REQUIRE(ok(stretch_statistics(*buffer, at_step(0), at_step(60), plain)));
            CHECK(means.w_B.x() == Approx(0.02));
            CHECK(means.a_B.z() == Approx(9.81));
            CHECK(means.a_sigma.z() < 1e-9);
            CHECK(std::abs(means.a_B.x()) < 3.0 * means.a_sigma.x() + 1e-4);
            CHECK(means.w_B.y() == Approx(0.1 * means.a_B.x()).margin(1e-12));
            worst = std::max(worst, std::abs(means.a_B.x()));
            worst_plain = std::max(worst_plain, std::abs(plain.mean_a_B.x()));
        }
        CAPTURE(f_hz, worst, worst_plain);
        CHECK(worst < 0.01);
        CHECK(worst < 0.3 * worst_plain);
    }
}

TEST_CASE("tapered means of white noise have the deviation that they report") {
    std::mt19937 rng(4);
    std::normal_distribution<double> normal;
    double squares = 0.0;
    double claims = 0.0;
    for (int run = 0; run < 200; ++run) {
        const auto buffer = std::make_unique<ImuBuffer>(200.0);
        for (int k = 0; k <= 60; ++k) {
            REQUIRE(ok(buffer->push({at_step(k), Eigen::Vector3d::Zero(), {0.1 * normal(rng), 0.0, 9.81}})));
        }
        TaperedMeans means;
        REQUIRE(ok(tapered_means(*buffer, at_step(0), at_step(60), means)));
        squares += means.a_B.x() * means.a_B.x();
        claims += means.a_sigma.x() * means.a_sigma.x();
    }
    CHECK(claims / squares == Approx(1.0).epsilon(0.3));
}

TEST_CASE("tapered means need a whole stretch of some length") {
    const auto buffer = std::make_unique<ImuBuffer>(200.0);
    for (int k = 0; k < 80; ++k) {
        REQUIRE(ok(buffer->push({at_step(k < 60 ? k : k + 10), Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}})));
    }
    TaperedMeans means;
    CHECK(ok(tapered_means(*buffer, at_step(0), at_step(50), means)));
    CHECK(tapered_means(*buffer, at_step(0), at_step(10), means) == Status::kNotReady);
    CHECK(tapered_means(*buffer, at_step(30), at_step(80), means) == Status::kDegenerate);
    CHECK(tapered_means(*buffer, at_step(50), at_step(200), means) == Status::kNotReady);
}

}  // namespace facet::stretch_test
