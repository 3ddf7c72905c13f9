// SPDX-License-Identifier: BSD-2-Clause
// The first state: gravity direction, biases, still or moving, and the prior's sigmas about the right axes.
#include "estimator/imu/static_init.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "tests/support/check_fields.h"

namespace facet::static_init_test {
namespace {

using Matrix15 = Eigen::Matrix<double, 15, 15>;

constexpr std::int64_t kStep_ns = 5'000'000;

/// What an IMU at attitude R(t) with acceleration a_W(t) reads, with EuRoC-grade noise.
struct Scenario {
    Eigen::Quaterniond q_W_B = Eigen::Quaterniond::Identity();
    ImuBias bias;
    double gravity = 9.81;
    Eigen::Vector3d rate_B = Eigen::Vector3d::Zero();  ///< constant
    std::function<Eigen::Vector3d(double)> a_W = [](double) { return Eigen::Vector3d::Zero(); };

    Eigen::Quaterniond attitude(double t) const { return q_W_B * so3_exp(t * rate_B); }

    std::unique_ptr<ImuBuffer> record(double duration_s, unsigned seed = 1) const {
        auto buffer = std::make_unique<ImuBuffer>(200.0);
        std::mt19937 rng(seed);
        std::normal_distribution<double> normal;
        const auto noise = [&](double sigma) {
            return Eigen::Vector3d(sigma * normal(rng), sigma * normal(rng), sigma * normal(rng));
        };
        for (std::int64_t k = 0; k * kStep_ns <= static_cast<std::int64_t>(duration_s * 1e9); ++k) {
            const double t = static_cast<double>(k * kStep_ns) * 1e-9;
            ImuSample s;
            s.stamp = Timestamp{k * kStep_ns};
            s.w_B = rate_B + bias.gyro + noise(2.4e-3);
            s.a_B = attitude(t).conjugate() * (a_W(t) - gravity_W(gravity)) + bias.accel + noise(2.8e-2);
            REQUIRE(ok(buffer->push(s)));
        }
        return buffer;
    }
};

Timestamp at_s(double t) { return Timestamp{Duration::from_seconds(t).ns}; }

/// Angle between true and estimated gravity direction, in B.
double tilt_error(const NavState& state, const Eigen::Quaterniond& q_W_B) {
    const Eigen::Vector3d up_estimated = state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up_true = q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    return std::atan2(up_estimated.cross(up_true).norm(), up_estimated.dot(up_true));
}

/// Standard deviation of a rotation error about an axis of W, from the prior.
double sigma_about_W(const InitialState& initial, const Eigen::Vector3d& axis_W) {
    // covariance = W^-1 W^-T, so the variance along a is |W^-T a|^2: well conditioned, unlike the covariance
    Eigen::Matrix<double, 15, 1> axis = Eigen::Matrix<double, 15, 1>::Zero();
    axis.segment<3>(kTheta) = initial.state.q_W_B.conjugate() * axis_W;
    return initial.sqrt_information.transpose().fullPivLu().solve(axis).norm();
}

}  // namespace

TEST_CASE("standing still: level, tilted, upside down, nose up") {
    const InitializerConfig config;
    const Eigen::Vector3d turns[] = {{0.0, 0.0, 0.0}, {0.3, -0.2, 1.0},    {3.1, 0.0, 0.0},
                                     {0.0, 1.2, 0.4}, {0.0, -1.5708, 0.0}, {0.0, 1.5708, 0.0}};
    for (const Eigen::Vector3d& turn : turns) {
        CAPTURE(turn.transpose());
        Scenario scenario;
        scenario.q_W_B = so3_exp(turn);
        scenario.bias.gyro = {-0.002, 0.02, 0.08};  // as large as EuRoC's
        InitialState initial;
        REQUIRE(ok(initialize_state(*scenario.record(1.2), at_s(1.1), 9.81, config, initial)));
        CHECK(initial.is_still);
        CHECK(tilt_error(initial.state, scenario.q_W_B) < 1e-3);
        CHECK((initial.state.bias.gyro - scenario.bias.gyro).norm() < 1e-3);
        CHECK(initial.state.bias.accel.norm() < 0.02);
        CHECK(initial.state.v_W_B.norm() == 0.0);
        CHECK(initial.state.p_W_B.norm() == 0.0);
        CHECK(std::abs(initial.state.q_W_B.norm() - 1.0) < 1e-12);
        // yaw zero: the x axis (or z, if x is upright) lies in the half plane y = 0, x > 0
        const Eigen::Vector3d x_W = initial.state.q_W_B * Eigen::Vector3d::UnitX();
        const Eigen::Vector3d forward_W =
            x_W.head<2>().norm() < 0.1 ? initial.state.q_W_B * Eigen::Vector3d::UnitZ() : x_W;
        CHECK(std::abs(forward_W.y()) < 1e-12);
        CHECK(forward_W.x() > 0.05);
    }
}

TEST_CASE("the prior at rest: yaw about the vertical, tilt as far as the bias is known, the rest diagonal") {
    const InitializerConfig config;
    const double tilt =
        std::hypot(config.accel_bias_sigma_m_per_s2, InitializerConfig::kStillAccelSigma_m_per_s2) / 9.81;
    Scenario scenario;
    scenario.q_W_B = so3_exp({0.7, -0.4, 0.2});
    InitialState initial;
    REQUIRE(ok(initialize_state(*scenario.record(1.0), at_s(1.0), 9.81, config, initial)));
    CHECK(initial.is_still);
    CHECK(initial.tilt_sigma_rad == Approx(tilt).epsilon(0.01));
    CHECK(sigma_about_W(initial, Eigen::Vector3d::UnitX()) == Approx(tilt).epsilon(0.01));
    CHECK(sigma_about_W(initial, Eigen::Vector3d::UnitY()) == Approx(tilt).epsilon(0.01));
    CHECK(sigma_about_W(initial, Eigen::Vector3d::UnitZ()) == Approx(1e-4).epsilon(1e-6));
    const Matrix15 information = initial.information();
    const auto sigma = [&](int offset) { return 1.0 / std::sqrt(information(offset, offset)); };
    CHECK(sigma(kPos) == Approx(1e-4));
    CHECK(sigma(kVel) == Approx(InitializerConfig::kStillVelocitySigma_m_per_s));
    CHECK(sigma(kBiasGyro) == Approx(InitializerConfig::kStillGyroBiasSigma_rad_per_s).epsilon(0.01));
    CHECK(information.block<3, 9>(kTheta, kPos).norm() == 0.0);
    CHECK(information.block<9, 9>(kPos, kPos).isDiagonal());
    CHECK(information.block<9, 3>(kPos, kBiasAccel).norm() == 0.0);
}

TEST_CASE("at rest a tilt and the bias that feigns it are one: what they predict together is what was measured") {
    const InitializerConfig config;
    Scenario scenario;
    scenario.q_W_B = so3_exp({0.7, -0.4, 0.2});
    scenario.bias.accel = {0.1, -0.15, 0.05};
    InitialState initial;
    REQUIRE(ok(initialize_state(*scenario.record(1.0), at_s(1.0), 9.81, config, initial)));
    REQUIRE(initial.is_still);
    // The true state at this yaw, as a correction of the first one: far in tilt and bias, but well within the prior.
    NavState truth = initial.state;
    const Eigen::Vector3d up_B = scenario.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d believed_B = initial.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    truth.q_W_B = initial.state.q_W_B * Eigen::Quaterniond::FromTwoVectors(up_B, believed_B);
    truth.bias = scenario.bias;
    const Eigen::Matrix<double, 15, 1> d = initial.state.box_minus_to(truth);
    CHECK(d.segment<3>(kTheta).norm() > 1.0 * initial.tilt_sigma_rad);
    CHECK((initial.sqrt_information * d).squaredNorm() < 6.0);
    // A tilt without the bias that would explain it contradicts the samples.
    Eigen::Matrix<double, 15, 1> alone = d;
    alone.segment<3>(kBiasAccel).setZero();
    CHECK((initial.sqrt_information * alone).squaredNorm() > 15.0);
    // What the vehicle seems to accelerate by is known far better than tilt or bias.
    const Eigen::Matrix3d R = initial.state.q_W_B.toRotationMatrix();
    Eigen::Matrix<double, 15, 1> along_x = Eigen::Matrix<double, 15, 1>::Zero();
    along_x.segment<3>(kTheta) = 9.81 * R.transpose() * Eigen::Vector3d::UnitX().cross(Eigen::Vector3d::UnitZ());
    along_x.segment<3>(kBiasAccel) = R.transpose() * Eigen::Vector3d::UnitX();
    const double sigma_x = initial.sqrt_information.transpose().fullPivLu().solve(along_x).norm();
    CHECK(sigma_x == Approx(InitializerConfig::kStillAccelSigma_m_per_s2).epsilon(0.05));
}

TEST_CASE("standing still, the accelerometer bias along gravity is seen") {
    Scenario scenario;
    scenario.bias.accel = {0.0, 0.0, 0.3};
    InitialState initial;
    REQUIRE(ok(initialize_state(*scenario.record(1.0), at_s(1.0), 9.81, InitializerConfig{}, initial)));
    CHECK(initial.is_still);
    CHECK((initial.state.bias.accel - scenario.bias.accel).norm() < 0.02);
}

TEST_CASE("standing where gravity is another, its strength is no bias") {
    Scenario scenario;
    scenario.gravity = 9.78;
    const auto buffer = scenario.record(1.0);
    InitialState known;
    InitialState wrong;
    REQUIRE(ok(initialize_state(*buffer, at_s(1.0), 9.78, InitializerConfig{}, known)));
    REQUIRE(ok(initialize_state(*buffer, at_s(1.0), 9.81, InitializerConfig{}, wrong)));
    CHECK(known.is_still);
    CHECK(known.state.bias.accel.norm() < 0.01);
    CHECK((known.state.bias.accel - wrong.state.bias.accel).norm() == Approx(0.03).epsilon(1e-9));
    CHECK(known.tilt_sigma_rad == Approx(wrong.tilt_sigma_rad).epsilon(0.01));  // rest is judged alike
}

TEST_CASE("shaken: moving, with gravity from the mean and honest sigmas") {
    const InitializerConfig config;
    Scenario scenario;
    scenario.q_W_B = so3_exp({0.2, 0.3, 0.0});
    scenario.bias.gyro = {-0.002, 0.02, 0.08};
    scenario.a_W = [](double t) { return Eigen::Vector3d(2.0 * std::sin(12.0 * t), 1.5 * std::cos(9.0 * t), 1.0); };
    InitialState initial;
    REQUIRE(ok(initialize_state(*scenario.record(1.5), at_s(1.5), 9.81, config, initial)));
    CHECK_FALSE(initial.is_still);
    CHECK(initial.state.bias.gyro.norm() == 0.0);
    CHECK(initial.state.bias.accel.norm() == 0.0);
    CHECK(initial.tilt_sigma_rad >= InitializerConfig::kMovingTiltSigma_rad);
    CHECK(tilt_error(initial.state, scenario.q_W_B) < 2.0 * initial.tilt_sigma_rad);
    CHECK(sigma_about_W(initial, Eigen::Vector3d::UnitX()) == Approx(initial.tilt_sigma_rad));
    CHECK(sigma_about_W(initial, Eigen::Vector3d::UnitZ()) == Approx(1e-4).epsilon(1e-6));
    const Matrix15 information = initial.information();
    CHECK(1.0 / std::sqrt(information(kVel, kVel)) == Approx(InitializerConfig::kMovingVelocitySigma_m_per_s));
    CHECK(1.0 / std::sqrt(information(kBiasGyro, kBiasGyro)) == Approx(config.gyro_bias_sigma_rad_per_s));
}

TEST_CASE("a wilder motion widens the tilt sigma beyond its least value") {
    const InitializerConfig config;
    Scenario scenario;
    scenario.a_W = [](double t) { return Eigen::Vector3d(8.0 * std::sin(7.0 * t), 6.0 * std::cos(5.0 * t), 2.0); };
    InitialState initial;
    REQUIRE(ok(initialize_state(*scenario.record(1.0), at_s(1.0), 9.81, config, initial)));
    CHECK_FALSE(initial.is_still);
    CHECK(initial.tilt_sigma_rad > 1.5 * InitializerConfig::kMovingTiltSigma_rad);
    CHECK(tilt_error(initial.state, scenario.q_W_B) < 2.0 * initial.tilt_sigma_rad);
}

TEST_CASE("a steady turn is motion, not bias, and gravity is taken in the last body frame") {
    const InitializerConfig config;
    Scenario scenario;
    scenario.rate_B = {0.9, 0.0, 0.0};  // rolls by 52 degrees in a second
    InitialState initial;
    REQUIRE(ok(initialize_state(*scenario.record(1.0), at_s(1.0), 9.81, config, initial)));
    CHECK_FALSE(initial.is_still);
    CHECK(initial.state.bias.gyro.norm() == 0.0);
    CHECK(tilt_error(initial.state, scenario.attitude(1.0)) < 5e-3);
}

TEST_CASE("only the newest stretch counts") {
    // GIVEN shaking that ends at 1 s, then a second and more of rest
    Scenario scenario;
    scenario.a_W = [](double t) { return Eigen::Vector3d(t < 1.0 ? 5.0 * std::sin(20.0 * t) : 0.0, 0.0, 0.0); };
    const auto buffer = scenario.record(2.5);
    InitialState initial;
    REQUIRE(ok(initialize_state(*buffer, at_s(1.5), 9.81, InitializerConfig{}, initial)));
    CHECK_FALSE(initial.is_still);
    REQUIRE(ok(initialize_state(*buffer, at_s(2.1), 9.81, InitializerConfig{}, initial)));
    CHECK(initial.is_still);
}

TEST_CASE("the first tenths of a second of a take-off are not standing still") {
    // GIVEN an acceleration that grows to 2 m/s^2 within a second, from the very first sample on
    Scenario scenario;
    scenario.a_W = [](double t) { return Eigen::Vector3d(0.0, 0.0, 1.0 - std::cos(M_PI * std::min(t, 1.0))); };
    for (const double t : {0.2, 0.3, 0.5}) {
        CAPTURE(t);
        InitialState initial;
        REQUIRE(ok(initialize_state(*scenario.record(0.6), at_s(t), 9.81, InitializerConfig{}, initial)));
        CHECK_FALSE(initial.is_still);
    }
    // while rest is told from its shortest stretch on, whatever the noise
    for (unsigned seed = 1; seed <= 100; ++seed) {
        const auto rest = Scenario{}.record(0.5, seed);
        for (const double t : {0.1, 0.2, 0.5}) {
            CAPTURE(seed, t);
            InitialState initial;
            REQUIRE(ok(initialize_state(*rest, at_s(t), 9.81, InitializerConfig{}, initial)));
            CHECK(initial.is_still);
        }
    }
}

TEST_CASE("too little data, or data with a gap, is not ready") {
    const InitializerConfig config;
    InitialState initial;
    initial.tilt_sigma_rad = -1.0;
    const auto empty = std::make_unique<ImuBuffer>(200.0);
    CHECK(initialize_state(*empty, at_s(0.5), 9.81, config, initial) == Status::kNotReady);
    const auto buffer = Scenario{}.record(0.5);
    CHECK(initialize_state(*buffer, at_s(0.05), 9.81, config, initial) == Status::kNotReady);
    CHECK(initialize_state(*buffer, at_s(-1.0), 9.81, config, initial) == Status::kNotReady);
    CHECK(initialize_state(*buffer, at_s(0.6), 9.81, config, initial) == Status::kNotReady);
    CHECK(initial.tilt_sigma_rad == -1.0);
    CHECK(ok(initialize_state(*buffer, at_s(0.1), 9.81, config, initial)));
    // samples come back after a gap of 0.2 s: the stretch starts anew
    for (int k = 0; k < 40; ++k) {
        REQUIRE(ok(buffer->push({at_s(0.7 + 0.005 * k), Eigen::Vector3d::Zero(), -gravity_W(9.81)})));
    }
    CHECK(initialize_state(*buffer, at_s(0.75), 9.81, config, initial) == Status::kNotReady);
    CHECK(ok(initialize_state(*buffer, at_s(0.85), 9.81, config, initial)));
}

TEST_CASE("free fall shows no direction") {
    Scenario scenario;
    scenario.a_W = [](double) { return gravity_W(9.81); };
    InitialState initial;
    CHECK(initialize_state(*scenario.record(1.0), at_s(1.0), 9.81, InitializerConfig{}, initial) ==
          Status::kDegenerate);
}

TEST_CASE("the config is validated field by field") { test::check_fields(kInitializerFields); }

TEST_CASE("at rest by images, shaken by rotors: gravity and gyroscope bias to a tenth of a degree and 1e-3 rad/s") {
    const InitializerConfig config;
    Scenario scenario;
    scenario.q_W_B = so3_exp({0.7, -0.4, 0.2});
    scenario.bias.gyro = {-0.002, 0.02, 0.01};
    scenario.a_W = [](double t) {
        return Eigen::Vector3d(0.9 * std::sin(107.0 * t + 0.3), 0.6 * std::cos(141.0 * t), 0.5 * std::sin(88.0 * t));
    };
    const auto buffer = scenario.record(1.0);
    InitialState initial;
    REQUIRE(ok(initialize_state(*buffer, at_s(0.4), 9.81, config, initial)));
    CHECK_FALSE(initial.is_still);  // by the samples alone
    REQUIRE(ok(initialize_shaken(*buffer, {at_s(0.1), at_s(0.4)}, 9.81, config, initial)));
    CHECK(initial.is_still);
    CHECK(tilt_error(initial.state, scenario.q_W_B) < 1.7e-3);
    CHECK((initial.state.bias.gyro - scenario.bias.gyro).norm() < 1e-3);
    CHECK(initial.state.v_W_B.norm() == 0.0);
    const double tilt =
        std::hypot(config.accel_bias_sigma_m_per_s2, InitializerConfig::kStillAccelSigma_m_per_s2) / 9.81;
    CHECK(initial.tilt_sigma_rad >= Approx(tilt));
    CHECK(initial.tilt_sigma_rad < 1.2 * tilt);

    scenario.rate_B = {0.0, 0.0, 0.3};
    CHECK(initialize_shaken(*scenario.record(1.0), {at_s(0.1), at_s(0.4)}, 9.81, config, initial) ==
          Status::kDegenerate);
    CHECK(initialize_shaken(*buffer, {at_s(0.1), at_s(0.15)}, 9.81, config, initial) == Status::kNotReady);
}

TEST_CASE("shaken: the sigmas of gravity and bias are cautious, but not three times too large") {
    const InitializerConfig config;
    std::mt19937 rng(3);
    std::uniform_real_distribution<double> phase(0.0, 6.2831853);
    double squares = 0.0;
    double claims = 0.0;
    for (int run = 0; run < 60; ++run) {
        std::array<double, 9> phases{};
        std::generate(phases.begin(), phases.end(), [&] { return phase(rng); });
        Scenario scenario;
        scenario.a_W = [&](double t) {  // 0.3 m/s^2 rms, flat from 5 to 25 Hz, as broad-band shaking of a real vehicle
            Eigen::Vector3d a_W = Eigen::Vector3d::Zero();
            for (std::size_t k = 0; k < phases.size(); ++k) {
                a_W.x() += 0.141 * std::sin(6.2831853 * (5.0 + 2.5 * static_cast<double>(k)) * t + phases.at(k));
            }
            return a_W;
        };
        const auto buffer = scenario.record(1.0);
        InitialState initial;
        REQUIRE(ok(initialize_shaken(*buffer, {at_s(0.1), at_s(0.4)}, 9.81, config, initial)));
        const double claim = 1.0 / initial.sqrt_information.block<1, 3>(kTheta, kBiasAccel).norm();
        claims +=
            claim * claim - InitializerConfig::kStillAccelSigma_m_per_s2 * InitializerConfig::kStillAccelSigma_m_per_s2;
        squares += std::pow(9.81 * tilt_error(initial.state, scenario.q_W_B), 2);
    }
    CAPTURE(std::sqrt(claims / 60.0), std::sqrt(squares / 60.0));
    CHECK(claims > squares);
    CHECK(claims < 9.0 * squares);
}

}  // namespace facet::static_init_test
