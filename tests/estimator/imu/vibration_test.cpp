// SPDX-License-Identifier: BSD-2-Clause
// Vibration: what the meter shows for white noise, tones and motion, and whether deltas integrated through it are as
// uncertain as their covariance says.
#include "estimator/imu/vibration.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

#include "estimator/imu/imu_buffer.h"

namespace facet::vibration_test {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;

constexpr double kRate = 200.0;
constexpr double kTwoPi = 6.283185307179586;

/// What a body reads that turns and swings slowly, with a tone on all axes.
struct Shaking {
    double frequency_hz = 100.0;
    Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< amplitudes (m/s^2)
    Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< (rad/s)
    Eigen::Vector3d accel_phase = Eigen::Vector3d::Zero();
    Eigen::Vector3d gyro_phase = Eigen::Vector3d::Zero();

    ImuSample sample(double t) const {
        const auto wave = [&](const Eigen::Vector3d& amplitude, const Eigen::Vector3d& phase) -> Eigen::Vector3d {
            return amplitude.array() * (kTwoPi * frequency_hz * t + phase.array()).cos();
        };
        ImuSample s;
        s.stamp = Timestamp{Duration::from_seconds(t).ns};
        s.w_B = Eigen::Vector3d(0.3 * std::sin(2.0 * t), 0.2 * std::cos(3.0 * t), 0.4) + wave(gyro, gyro_phase);
        s.a_B = Eigen::Vector3d(std::sin(3.0 * t), std::cos(2.0 * t), 9.81) + wave(accel, accel_phase);
        return s;
    }
};

struct Trial {
    double frequency_hz = 0.0;  ///< 0: drawn from 80 to 120 Hz
    double accel_rms = 0.0;     ///< per axis
    double gyro_rms = 0.0;
    double white_scale = 1.0;  ///< of the true white noise over the configured
    double interval_s = 0.2;   ///< give or take a tenth
    bool is_z_only = false;
    bool is_sensor_only = false;  ///< the body itself moves without the tone
};

/// Adds the ripple of the velocity at the beginning and the end of an interval to the covariance of its deltas.
void add_ripple(const Eigen::Vector3d& ripple, double interval_s, Eigen::Matrix<double, 9, 9>& covariance) {
    const Eigen::Matrix3d r = ripple.asDiagonal();
    covariance.block<3, 3>(kPos, kPos) += interval_s * interval_s * r;
    covariance.block<3, 3>(kPos, kVel) += interval_s * r;
    covariance.block<3, 3>(kVel, kPos) += interval_s * r;
    covariance.block<3, 3>(kVel, kVel) += 2.0 * r;
}

/// Mean of (delta error)' covariance^-1 (delta error) over its dimension: [all, theta, p and v].
Eigen::Vector3d normalised_error(const Trial& trial, int runs) {
    const ImuNoise noise;
    std::mt19937 rng(11);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const auto gaussian = [&] { return Eigen::Vector3d(normal(rng), normal(rng), normal(rng)); };
    const auto phases = [&] {
        return Eigen::Vector3d(kTwoPi * Eigen::Array3d(uniform(rng), uniform(rng), uniform(rng)));
    };
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int run = 0; run < runs; ++run) {
        Shaking body;
        body.frequency_hz = trial.frequency_hz > 0.0 ? trial.frequency_hz : 80.0 + 40.0 * uniform(rng);
        const Eigen::Vector3d axes = trial.is_z_only ? Eigen::Vector3d(0.0, 0.0, 1.0) : Eigen::Vector3d::Ones();
        body.accel = std::sqrt(2.0) * trial.accel_rms * axes;
        body.gyro = std::sqrt(2.0) * trial.gyro_rms * axes;
        body.accel_phase = phases();
        body.gyro_phase = phases();
        const auto buffer = std::make_unique<ImuBuffer>(kRate);
        const double root_rate = std::sqrt(kRate) * trial.white_scale;
        for (int k = 0; k <= 350; ++k) {
            ImuSample s = body.sample(k / kRate);
            s.w_B += root_rate * noise.gyro_noise_rad_per_s_per_sqrt_hz * gaussian();
            s.a_B += root_rate * noise.accel_noise_m_per_s2_per_sqrt_hz * gaussian();
            REQUIRE(ok(buffer->push(s)));
        }
        const double begin = 1.0 + 0.02 * uniform(rng);
        const double interval_s = trial.interval_s * (0.9 + 0.2 * uniform(rng));  // no whole number of periods
        const int fine_steps = static_cast<int>(std::lround(interval_s * 4000.0));
        const double h = interval_s / fine_steps;
        const Shaking moves = trial.is_sensor_only ? Shaking{} : body;
        Preintegration truth;
        for (int k = 0; k < fine_steps; ++k) {
            REQUIRE(ok(truth.integrate(moves.sample(begin + k * h), moves.sample(begin + (k + 1) * h), noise)));
        }
        Preintegration pre;
        REQUIRE(
            ok(buffer->integrate_between(body.sample(begin).stamp, body.sample(begin + interval_s).stamp, noise, pre)));
        Vector9 e;
        e << so3_log(truth.delta_q().conjugate() * pre.delta_q()), pre.delta_p() - truth.delta_p(),
            pre.delta_v() - truth.delta_v();
        Eigen::Matrix<double, 9, 9> c = pre.covariance();
        add_ripple(buffer->velocity_ripple(), interval_s, c);
        const Eigen::Vector3d theta = e.head<3>();
        const Eigen::Matrix<double, 6, 1> pv = e.tail<6>();
        sum +=
            Eigen::Vector3d(e.dot(c.llt().solve(e)) / 9.0, theta.dot(c.topLeftCorner<3, 3>().llt().solve(theta)) / 3.0,
                            pv.dot(c.bottomRightCorner<6, 6>().llt().solve(pv)) / 6.0);
    }
    return sum / runs;
}

void check_near_one(const Eigen::Vector3d& nees) {
    CAPTURE(nees.transpose());
    CHECK(nees.maxCoeff() < 1.3);
    CHECK(nees.minCoeff() > 0.3);
}

}  // namespace

TEST_CASE("white noise shows its variance in both bands, a tone in one, motion in none") {
    std::mt19937 rng(4);
    std::normal_distribution<double> normal;
    VibrationMeter meter(kRate);
    double white = 0.0;
    double tone = 0.0;
    constexpr int kSamples = 4000;
    for (int k = 0; k < kSamples; ++k) {
        ImuSample s;
        s.w_B.x() = 0.3 * normal(rng);
        s.a_B.x() = 2.0 * std::cos(kTwoPi * 97.0 * k / kRate);
        s.a_B.y() = 3.0 * std::sin(kTwoPi * 3.0 * k / kRate);
        s.a_B.z() = 9.81;
        s.w_B.z() = 0.1 * std::cos(kTwoPi * 25.0 * k / kRate);
        meter.add(s);
        if (k > 100) {
            white += meter.level().white()[0] / (kSamples - 101);
            tone += meter.level().tone()[0] / (kSamples - 101);
        }
    }
    // the lesser of two estimates is a little low
    CHECK(white == Approx(0.09).epsilon(0.15));
    CHECK(tone < 0.2 * white);
    CHECK(meter.level().white()[3] < 1e-4);
    CHECK(meter.level().tone()[3] == Approx(2.0 * 3.66).epsilon(0.05));
    CHECK(meter.level().tone()[4] < 1e-6);
    CHECK(meter.level().tone()[2] == 0.0F);
    CHECK(meter.level().rumble()[2] == Approx(0.005 * 2.75).epsilon(0.05));
    CHECK(meter.level().rumble()[3] == 0.0F);
    CHECK(meter.level().white()[4] < 1e-6);
    CHECK(meter.level().white()[5] < 1e-12);
    // the level stays over a break and is gone after clear
    meter.restart();
    meter.add({});
    CHECK(meter.level().tone()[3] > 5.0F);
    meter.clear(kRate);
    CHECK(meter.level().tone()[3] == 0.0F);
}

TEST_CASE("without vibration the noise is the configured one") {
    const Eigen::Vector3d nees = normalised_error({}, 150);
    CAPTURE(nees.transpose());
    CHECK(nees.maxCoeff() < 1.15);
    CHECK(nees.minCoeff() > 0.85);
}

TEST_CASE("deltas through vibration of 80 to 120 Hz at 200 Hz are as uncertain as they say") {
    for (const double rms : {0.5, 1.0, 3.0}) {
        for (const double interval_s : {0.1, 0.2, 0.5}) {
            CAPTURE(rms, interval_s);
            check_near_one(normalised_error({.accel_rms = rms, .gyro_rms = 0.1 * rms, .interval_s = interval_s}, 120));
        }
    }
}

TEST_CASE("single frequencies of that band, and a single axis") {
    for (const double frequency_hz : {80.0, 90.0, 97.0, 103.0, 110.0, 120.0}) {
        CAPTURE(frequency_hz);
        check_near_one(normalised_error({.frequency_hz = frequency_hz, .accel_rms = 2.0, .gyro_rms = 0.1}, 120));
    }
    check_near_one(normalised_error({.accel_rms = 3.0, .gyro_rms = 0.2, .is_z_only = true}, 120));
}

TEST_CASE("what rumbles in the mid band alone is an error at either end, and does not accumulate") {
    std::mt19937 rng(5);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (const double interval_s : {0.1, 0.2, 0.5}) {
        double sum = 0.0;
        constexpr int kTones = 20;
        for (int k = 0; k < kTones; ++k) {
            const Trial trial{.frequency_hz = 20.0 + 20.0 * uniform(rng),
                              .gyro_rms = 0.05,
                              .interval_s = interval_s,
                              .is_sensor_only = true};
            sum += normalised_error(trial, 10)[1] / kTones;
        }
        // 0.3 mrad that only the gyroscope shows: without the band's part they would count a hundredfold
        CAPTURE(interval_s, sum);
        CHECK(sum < 2.5);
        CHECK(sum > 0.4);
    }
}

TEST_CASE("broad-band shaking, white after sampling, raises the noise to what is seen") {
    check_near_one(normalised_error({.white_scale = 10.0}, 150));
    check_near_one(normalised_error({.white_scale = 100.0, .interval_s = 0.5}, 150));
}

TEST_CASE(
    "the noise of an interval is a function of the samples: integrated again it is the same, and it is reported") {
    const ImuNoise noise;
    Shaking body;
    body.frequency_hz = 97.0;
    body.accel = {0.0, 0.0, 2.0};
    const auto buffer = std::make_unique<ImuBuffer>(kRate);
    ImuSpan span;
    Preintegration first;
    Preintegration again;
    for (int k = 0; k < 600; ++k) {
        // quiet for a second, then a tone, then white noise of 1 m/s^2 (a fixed sequence)
        ImuSample s = k < 200 ? Shaking{}.sample(k / kRate) : body.sample(k / kRate);
        s.a_B.x() += k < 400 ? 0.0 : std::fmod(k * k * 0.618034, 1.0) * 3.46;
        REQUIRE(ok(buffer->push(s)));
        if (k == 380) {
            REQUIRE(
                ok(buffer->integrate_between(Timestamp{1'600'000'000}, Timestamp{1'800'000'000}, noise, first, &span)));
        }
    }
    CHECK(span.accel_vibration_m_per_s2 == Approx(std::sqrt(2.0 * 3.66)).epsilon(0.1));
    CHECK(span.gyro_vibration_rad_per_s < 1e-3);
    CHECK(span.accel_noise_ratio < 3.0);
    REQUIRE(ok(buffer->integrate_between(Timestamp{1'600'000'000}, Timestamp{1'800'000'000}, noise, again, &span)));
    CHECK((first.covariance() - again.covariance()).norm() == 0.0);
    REQUIRE(ok(buffer->integrate_between(Timestamp{400'000'000}, Timestamp{900'000'000}, noise, again, &span)));
    CHECK(span.accel_noise_ratio == 1.0);
    CHECK(span.gyro_noise_ratio == 1.0);
    CHECK(span.accel_vibration_m_per_s2 < 0.01);
    REQUIRE(ok(buffer->integrate_between(Timestamp{2'700'000'000}, Timestamp{2'900'000'000}, noise, again, &span)));
    CHECK(span.accel_noise_ratio > 10.0);
}

}  // namespace facet::vibration_test
