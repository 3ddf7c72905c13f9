// SPDX-License-Identifier: BSD-2-Clause
// Rest and what is not: hand motion, take-off, turns, vibration; and the one case the samples cannot tell.
#include "estimator/imu/stationarity.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <random>

namespace facet::stationarity_test {
namespace {

constexpr double kRate = 200.0;
const ImuNoise kNoise;

struct Motion {
    std::function<Eigen::Vector3d(double)> w_B = [](double) { return Eigen::Vector3d::Zero(); };
    std::function<Eigen::Vector3d(double)> a_W = [](double) { return Eigen::Vector3d::Zero(); };
    ImuBias bias;

    /// Samples with the configured noise; attitude near level, so that forces are those of W.
    std::unique_ptr<ImuBuffer> record(double duration_s, unsigned seed = 1) const {
        const ImuNoise noise;
        auto buffer = std::make_unique<ImuBuffer>(kRate);
        std::mt19937 rng(seed);
        std::normal_distribution<double> normal;
        Eigen::Quaterniond q_W_B = Eigen::Quaterniond::Identity();
        for (int k = 0; k <= static_cast<int>(duration_s * kRate); ++k) {
            const double t = k / kRate;
            const auto gaussian = [&](double density) {
                return Eigen::Vector3d(Eigen::Vector3d(normal(rng), normal(rng), normal(rng)) * density *
                                       std::sqrt(kRate));
            };
            ImuSample s;
            s.stamp = Timestamp{Duration::from_seconds(t).ns};
            s.w_B = w_B(t) + bias.gyro + gaussian(noise.gyro_noise_rad_per_s_per_sqrt_hz);
            s.a_B = q_W_B.conjugate() * (a_W(t) - gravity_W(9.81)) + bias.accel +
                    gaussian(noise.accel_noise_m_per_s2_per_sqrt_hz);
            REQUIRE(ok(buffer->push(s)));
            q_W_B = q_W_B * so3_exp(w_B(t) / kRate);
        }
        return buffer;
    }

    /// Share of stamps, every 50 ms, at which the samples do not speak against rest.
    double rest_share(double from_s, double to_s, const ImuBias& known = {}, double gravity = 9.81) const {
        const auto buffer = record(to_s);
        int rests = 0;
        int all = 0;
        for (double t = from_s; t < to_s; t += 0.05) {
            Stationarity rest;
            REQUIRE(ok(measure_stationarity(*buffer, Timestamp{Duration::from_seconds(t).ns}, {kNoise, known, gravity},
                                            rest)));
            CHECK(rest.may_be_at_rest == (rest.measure < 1.0));
            rests += rest.may_be_at_rest ? 1 : 0;
            ++all;
        }
        return static_cast<double>(rests) / all;
    }
};

}  // namespace

TEST_CASE("at rest, with known and with slightly wrong biases") {
    Motion rest;
    CHECK(rest.rest_share(0.5, 20.0) == 1.0);
    rest.bias.gyro = {-0.002, 0.02, 0.08};
    rest.bias.accel = {-0.02, 0.13, 0.08};
    CHECK(rest.rest_share(0.5, 10.0, rest.bias) == 1.0);
    ImuBias nearly = rest.bias;
    nearly.gyro.x() += 0.008;
    nearly.accel.setZero();
    CHECK(rest.rest_share(0.5, 10.0, nearly) == 1.0);
    // an unknown bias is taken for a turn
    CHECK(rest.rest_share(0.5, 10.0) == 0.0);
}

TEST_CASE("rest is judged by the gravity of the place") {
    CHECK(Motion{}.rest_share(0.5, 5.0, {}, 9.78) == 1.0);
    CHECK(Motion{}.rest_share(0.5, 5.0, {}, 1.62) == 0.0);  // on the moon, this is a lift that starts
}

TEST_CASE("gentle hand motion and slow smooth flight are not rest") {
    // swaying by hand: 10 cm at 0.4 Hz and slow turns, as in the first seconds of a hand-held start
    Motion hand;
    hand.a_W = [](double t) {
        return Eigen::Vector3d(0.63 * std::sin(2.5 * t), 0.4 * std::cos(2.1 * t), 0.2 * std::sin(1.7 * t));
    };
    hand.w_B = [](double t) {
        return Eigen::Vector3d(0.08 * std::sin(1.9 * t), 0.06 * std::cos(2.3 * t), 0.1 * std::sin(1.1 * t));
    };
    CHECK(hand.rest_share(0.5, 20.0) < 0.01);
    // the same without turning: only where all accelerations are at their extremes at once the forces stand still
    hand.w_B = [](double) { return Eigen::Vector3d::Zero(); };
    CHECK(hand.rest_share(0.5, 20.0) < 0.05);
    // a quarter of it still
    Motion slow;
    slow.a_W = [&](double t) { return (0.25 * hand.a_W(t)).eval(); };
    CHECK(slow.rest_share(0.5, 20.0) < 0.35);
}

TEST_CASE("turning, shaking, falling, speeding up") {
    Motion turn;
    turn.w_B = [](double) { return Eigen::Vector3d(0.0, 0.0, 0.03); };
    CHECK(turn.rest_share(0.5, 5.0) == 0.0);
    Motion hover;
    hover.a_W = [](double t) { return Eigen::Vector3d(0.0, 0.0, 0.3 * std::cos(570.0 * t)); };
    CHECK(hover.rest_share(0.5, 5.0) == 0.0);
    Motion fall;
    fall.a_W = [](double) { return gravity_W(9.81); };
    CHECK(fall.rest_share(0.5, 5.0) == 0.0);
    Motion climb;
    climb.a_W = [](double) { return Eigen::Vector3d(0.0, 0.0, 0.5); };
    CHECK(climb.rest_share(0.5, 5.0) == 0.0);
}

TEST_CASE("a take-off is detected before it has 2 cm/s, and stays detected") {
    // GIVEN rest, then from 1 s on an acceleration that grows to 2 m/s^2 within a second
    constexpr double kStart = 1.0;
    Motion take_off;
    take_off.a_W = [](double t) {
        const double phase = std::clamp(t - kStart, 0.0, 1.0);
        return Eigen::Vector3d(0.0, 0.0, 1.0 - std::cos(M_PI * phase));
    };
    const auto buffer = take_off.record(2.0);
    double speed_told = -1.0;
    for (double t = 0.6; t < 2.0; t += 0.02) {
        Stationarity rest;
        REQUIRE(ok(measure_stationarity(*buffer, Timestamp{Duration::from_seconds(t).ns}, {kNoise, {}, 9.81}, rest)));
        const double since = std::max(0.0, t - kStart);
        const double speed = since - std::sin(M_PI * since) / M_PI;
        if (t < kStart) {
            CHECK(rest.may_be_at_rest);
        } else if (!rest.may_be_at_rest && speed_told < 0.0) {
            speed_told = speed;
        } else if (speed_told >= 0.0) {
            CHECK_FALSE(rest.may_be_at_rest);
        }
    }
    CHECK(speed_told >= 0.0);
    CHECK(speed_told < 0.02);
}

TEST_CASE("steady straight flight is what the IMU alone cannot tell from rest") {
    // The samples are those of rest: only the images can speak.
    CHECK(Motion{}.rest_share(0.5, 5.0) == 1.0);
}

TEST_CASE("too little data is not ready, broken data shows nothing") {
    const auto buffer = Motion{}.record(1.0);
    Stationarity rest;
    rest.measure = -1.0;
    const auto measure = [&](double t) {
        return measure_stationarity(*buffer, Timestamp{Duration::from_seconds(t).ns}, {kNoise, {}, 9.81}, rest);
    };
    CHECK(measure(0.4) == Status::kNotReady);
    CHECK(measure(1.1) == Status::kNotReady);
    CHECK(rest.measure == -1.0);
    REQUIRE(ok(buffer->push({Timestamp{1'100'000'000}, Eigen::Vector3d::Zero(), -gravity_W(9.81)})));
    CHECK(measure(1.1) == Status::kDegenerate);
    REQUIRE(ok(buffer->push({Timestamp{1'105'000'000}, Eigen::Vector3d::Zero(), {0.0, 0.0, 1e3}})));
    CHECK(measure(1.105) == Status::kDegenerate);
    CHECK(rest.measure == -1.0);
    CHECK(measure_stationarity(*std::make_unique<ImuBuffer>(), Timestamp{0}, {kNoise, {}, 9.81}, rest) ==
          Status::kNotReady);
}

}  // namespace facet::stationarity_test
