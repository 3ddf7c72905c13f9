// SPDX-License-Identifier: BSD-2-Clause
// The inertial factor: zero at the prediction, Jacobians against numeric ones, whitening against Monte Carlo.
#include "estimator/factors/imu_factor.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/support/numeric_jacobian.h"

namespace facet::imu_factor_test {
namespace {

using Vector15 = Eigen::Matrix<double, 15, 1>;
using Matrix15 = Eigen::Matrix<double, 15, 15>;

constexpr std::int64_t kStep_ns = 5'000'000;

Eigen::Vector3d normal3(std::mt19937& rng, double sigma) {
    std::normal_distribution<double> normal(0.0, sigma);
    return {normal(rng), normal(rng), normal(rng)};
}

Vector15 normal15(std::mt19937& rng, double sigma) {
    std::normal_distribution<double> normal(0.0, sigma);
    return Vector15::NullaryExpr([&](Eigen::Index) { return normal(rng); });
}

/// Lively motion: several rad/s and several m/s^2 on top of gravity.
ImuSample sample_at(int k) {
    const double t = static_cast<double>(k * kStep_ns) * 1e-9;
    ImuSample s;
    s.stamp = Timestamp{k * kStep_ns};
    s.w_B = {1.5 * std::sin(7.0 * t), -0.8 + std::cos(5.0 * t), 2.0 * std::sin(3.0 * t + 1.0)};
    s.a_B = {3.0 * std::cos(4.0 * t), 2.0 * std::sin(9.0 * t), 9.81 + 1.5 * std::sin(6.0 * t)};
    return s;
}

Preintegration preintegrate(int steps, const ImuNoise& noise, const ImuBias& bias = {}, double gravity = 9.81,
                            bool differentiate_scale = false) {
    Preintegration pre(bias, gravity);
    pre.set_scale({}, differentiate_scale);
    for (int k = 0; k < steps; ++k) {
        REQUIRE(ok(pre.integrate(sample_at(k), sample_at(k + 1), noise)));
    }
    return pre;
}

NavState random_state(std::mt19937& rng) {
    NavState s;
    s.q_W_B = so3_exp(normal3(rng, 1.0));
    s.p_W_B = normal3(rng, 5.0);
    s.v_W_B = normal3(rng, 2.0);
    s.bias.gyro = normal3(rng, 0.02);
    s.bias.accel = normal3(rng, 0.1);
    return s;
}

/// Compares row by row, so that a weakly weighted row counts as much as a strongly weighted one.
void expect_rows_match(const Matrix15& analytic, const Eigen::MatrixXd& numeric, double tolerance) {
    Matrix15 a = analytic;
    Eigen::MatrixXd n = numeric;
    for (int row = 0; row < 15; ++row) {
        const double scale = numeric.row(row).cwiseAbs().maxCoeff();
        REQUIRE(scale > 0.0);
        a.row(row) /= scale;
        n.row(row) /= scale;
    }
    test::expect_jacobian_near(a, n, tolerance);
}

void expect_jacobians_match(const ImuFactor& factor, const NavState& i, const NavState& j,
                            const ImuFactorLinearization& lin) {
    const Vector15 zero = Vector15::Zero();
    const auto by_i = [&](const Vector15& d) { return factor.residual(i.box_plus(d), j); };
    const auto by_j = [&](const Vector15& d) { return factor.residual(i, j.box_plus(d)); };
    expect_rows_match(lin.d_r_d_i, test::numeric_jacobian(by_i, zero, 1e-5), 1e-6);
    expect_rows_match(lin.d_r_d_j, test::numeric_jacobian(by_j, zero, 1e-5), 1e-6);
}

}  // namespace

TEST_CASE("the inertial residual vanishes at the prediction and grows away from it") {
    const ImuNoise noise;
    std::mt19937 rng(3);
    ImuFactor factor;
    REQUIRE(ok(factor.set(preintegrate(50, noise), noise)));
    for (int trial = 0; trial < 5; ++trial) {
        const NavState i = random_state(rng);
        const NavState j = factor.preintegration().predict(i);
        CHECK(factor.residual(i, j).norm() < 1e-6);
        CHECK(factor.residual(i, j.box_plus(Vector15::Constant(1e-2))).norm() > 1.0);
    }
}

TEST_CASE("inertial Jacobians match numeric differentiation") {
    const ImuNoise noise;
    for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
        CAPTURE(seed);
        std::mt19937 rng(seed);
        // GIVEN a bias away from the preintegration's, and a state j away from the prediction
        ImuBias bias_lin;
        bias_lin.gyro = normal3(rng, 0.02);
        bias_lin.accel = normal3(rng, 0.1);
        ImuFactor factor;
        REQUIRE(ok(factor.set(preintegrate(40, noise, bias_lin), noise)));
        const NavState i = random_state(rng);
        const NavState j = factor.preintegration().predict(i).box_plus(normal15(rng, 0.3));
        // WHEN linearised THEN both Jacobians agree and r is the residual
        ImuFactorLinearization lin;
        factor.linearize(i, j, i, j, lin);
        CHECK((lin.r - factor.residual(i, j)).norm() < 1e-9 * (1.0 + lin.r.norm()));
        expect_jacobians_match(factor, i, j, lin);
    }
}

TEST_CASE("residual and Jacobians follow the scale of the IMU's axes") {
    const ImuNoise noise;
    for (const unsigned seed : {1U, 2U, 3U}) {
        std::mt19937 rng(seed);
        ImuFactor factor;
        REQUIRE(ok(factor.set(preintegrate(40, noise, {}, 9.81, true), noise)));
        const NavState i = random_state(rng);
        const NavState j = factor.preintegration().predict(i).box_plus(normal15(rng, 0.1));
        std::normal_distribution<double> normal(0.0, 0.003);
        const ImuScale scale =
            ImuScale{}.box_plus(ImuScale::Tangent::NullaryExpr([&](Eigen::Index) { return normal(rng); }));
        ImuFactorLinearization lin;
        factor.linearize(i, j, i, j, lin, &scale);
        CHECK((lin.r - factor.residual(i, j, &scale)).norm() < 1e-9 * (1.0 + lin.r.norm()));
        const auto by_scale = [&](const ImuScale::Tangent& d) {
            const ImuScale moved = scale.box_plus(d);
            return factor.residual(i, j, &moved);
        };
        const Eigen::MatrixXd numeric = test::numeric_jacobian(by_scale, ImuScale::Tangent::Zero().eval(), 1e-5);
        const double largest = numeric.cwiseAbs().maxCoeff();
        CHECK((numeric - lin.d_r_d_scale).cwiseAbs().maxCoeff() < 1e-5 * largest);
        // The states' Jacobians are those at this scale.
        const auto by_i = [&](const Vector15& d) { return factor.residual(i.box_plus(d), j, &scale); };
        expect_rows_match(lin.d_r_d_i, test::numeric_jacobian(by_i, Vector15::Zero().eval(), 1e-5), 1e-6);
    }
}

TEST_CASE("residual and Jacobians follow the gravity of the preintegration") {
    const ImuNoise noise;
    std::mt19937 rng(5);
    ImuFactor factor;
    REQUIRE(ok(factor.set(preintegrate(50, noise, {}, 9.78), noise)));
    const NavState i = random_state(rng);
    const NavState j = factor.preintegration().predict(i);
    CHECK(factor.residual(i, j).norm() < 1e-6);
    CHECK((j.v_W_B - preintegrate(50, noise).predict(i).v_W_B).isApprox(Eigen::Vector3d(0.0, 0.0, 0.03 * 0.25), 1e-9));
    const NavState far = j.box_plus(normal15(rng, 0.3));
    ImuFactorLinearization lin;
    factor.linearize(i, far, i, far, lin);
    expect_jacobians_match(factor, i, far, lin);

    // First-estimate Jacobians keep the null space: moving both states by an error of the yaw changes nothing.
    const Eigen::Vector3d yaw_B = i.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    Vector15 turn_i = Vector15::Zero();
    Vector15 turn_j = Vector15::Zero();
    turn_i.segment<3>(kTheta) = yaw_B;
    turn_i.segment<3>(kPos) = Eigen::Vector3d::UnitZ().cross(i.p_W_B);
    turn_i.segment<3>(kVel) = Eigen::Vector3d::UnitZ().cross(i.v_W_B);
    turn_j.segment<3>(kTheta) = far.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    turn_j.segment<3>(kPos) = Eigen::Vector3d::UnitZ().cross(far.p_W_B);
    turn_j.segment<3>(kVel) = Eigen::Vector3d::UnitZ().cross(far.v_W_B);
    CHECK((lin.d_r_d_i * turn_i + lin.d_r_d_j * turn_j).norm() < 1e-8 * (lin.d_r_d_i * turn_i).norm());
}

TEST_CASE("first-estimate Jacobians are those of the linearization points, the residual that of the states") {
    const ImuNoise noise;
    std::mt19937 rng(11);
    ImuFactor factor;
    REQUIRE(ok(factor.set(preintegrate(40, noise), noise)));
    const NavState i_lin = random_state(rng);
    const NavState j_lin = factor.preintegration().predict(i_lin).box_plus(normal15(rng, 0.1));
    const NavState i = i_lin.box_plus(normal15(rng, 0.1));
    const NavState j = j_lin.box_plus(normal15(rng, 0.1));
    ImuFactorLinearization lin;
    factor.linearize(i, j, i_lin, j_lin, lin);
    CHECK((lin.r - factor.residual(i, j)).norm() < 1e-9 * (1.0 + lin.r.norm()));
    expect_jacobians_match(factor, i_lin, j_lin, lin);
    ImuFactorLinearization at_states;
    factor.linearize(i, j, i, j, at_states);
    CHECK((lin.d_r_d_i - at_states.d_r_d_i).norm() > 1e-3 * at_states.d_r_d_i.norm());
}

TEST_CASE("whitened residuals of noisy inertial data have unit covariance") {
    ImuNoise noise;
    noise.gyro_noise_rad_per_s_per_sqrt_hz = 2e-3;  // large against the least standard deviations
    noise.accel_noise_m_per_s2_per_sqrt_hz = 2e-2;
    constexpr int kSteps = 40;
    constexpr int kRuns = 1000;
    const double dt = kStep_ns * 1e-9;
    const double gyro_sigma = noise.gyro_noise_rad_per_s_per_sqrt_hz / std::sqrt(dt);
    const double accel_sigma = noise.accel_noise_m_per_s2_per_sqrt_hz / std::sqrt(dt);
    const double gyro_walk = noise.gyro_walk_rad_per_s2_per_sqrt_hz * std::sqrt(kSteps * dt);
    const double accel_walk = noise.accel_walk_m_per_s3_per_sqrt_hz * std::sqrt(kSteps * dt);
    std::mt19937 rng(5);
    const NavState i = random_state(rng);
    Preintegration truth(i.bias);
    for (int k = 0; k < kSteps; ++k) {
        REQUIRE(ok(truth.integrate(sample_at(k), sample_at(k + 1), noise)));
    }
    const NavState j_no_walk = truth.predict(i);

    Vector15 sum_squares = Vector15::Zero();
    for (int run = 0; run < kRuns; ++run) {
        Preintegration noisy(i.bias);
        ImuSample previous = sample_at(0);
        previous.w_B += normal3(rng, gyro_sigma);
        previous.a_B += normal3(rng, accel_sigma);
        for (int k = 1; k <= kSteps; ++k) {
            ImuSample next = sample_at(k);
            next.w_B += normal3(rng, gyro_sigma);
            next.a_B += normal3(rng, accel_sigma);
            REQUIRE(ok(noisy.integrate(previous, next, noise)));
            previous = next;
        }
        ImuFactor factor;
        REQUIRE(ok(factor.set(noisy, noise)));
        NavState j = j_no_walk;
        j.bias.gyro += normal3(rng, gyro_walk);
        j.bias.accel += normal3(rng, accel_walk);
        sum_squares += factor.residual(i, j).cwiseAbs2();
    }
    // chi2 with 15 degrees of freedom: mean 15, standard error of the mean sqrt(30 / 1000) = 0.17. Averaging adjacent
    // samples halves the weight of the two end samples: 1/80 less than white noise.
    CHECK(sum_squares.sum() / kRuns == Approx(15.0).margin(0.8));
    for (int row = 0; row < 15; ++row) {
        CAPTURE(row);
        CHECK(sum_squares(row) / kRuns == Approx(1.0).margin(0.2));
    }
}

TEST_CASE("an inertial factor needs time, bias walk and finite data") {
    const ImuNoise noise;
    ImuFactor factor;
    REQUIRE(ok(factor.set(preintegrate(10, noise), noise)));
    const double before = factor.preintegration().dt_s();
    CHECK(factor.set(Preintegration{}, noise) == Status::kDegenerate);
    ImuNoise no_walk = noise;
    no_walk.gyro_walk_rad_per_s2_per_sqrt_hz = 0.0;
    CHECK(factor.set(preintegrate(10, no_walk), no_walk) == Status::kDegenerate);
    ImuNoise broken = noise;
    broken.gyro_noise_rad_per_s_per_sqrt_hz = std::nan("");
    CHECK(factor.set(preintegrate(10, broken), noise) == Status::kDegenerate);
    CHECK(factor.preintegration().dt_s() == before);
}

TEST_CASE("an inertial factor over a single short step has a bounded, finite weight") {
    const ImuNoise noise;
    Preintegration pre;
    ImuSample a = sample_at(0);
    ImuSample b = sample_at(0);
    b.stamp = a.stamp + Duration{1000};  // 1 us
    REQUIRE(ok(pre.integrate(a, b, noise)));
    ImuFactor factor;
    REQUIRE(ok(factor.set(pre, noise)));
    const NavState i;
    NavState j = pre.predict(i);
    j.p_W_B.x() += 1e-5;
    const Vector15 r = factor.residual(i, j);
    CHECK(r.allFinite());
    CHECK(r.norm() <= 1.001);
    CHECK(r.norm() > 0.5);
}

}  // namespace facet::imu_factor_test
