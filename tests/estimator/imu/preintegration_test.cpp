// SPDX-License-Identifier: BSD-2-Clause
// Preintegration against closed forms and an analytic flight; bias Jacobians and covariance against re-integration.
#include "estimator/imu/preintegration.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/support/numeric_jacobian.h"

namespace facet::preintegration_test {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Vector15 = Eigen::Matrix<double, 15, 1>;

/// A wavy flight with position and Euler angles (yaw, pitch, roll; R = Rz Ry Rx) in closed form.
struct WavyFlight {
    static NavState state(double t) {
        NavState s;
        s.p_W_B = {1.5 * std::sin(1.2 * t), std::cos(0.9 * t), 0.5 * std::sin(2.0 * t)};
        s.v_W_B = {1.8 * std::cos(1.2 * t), -0.9 * std::sin(0.9 * t), std::cos(2.0 * t)};
        s.q_W_B = Eigen::AngleAxisd(yaw(t), Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(pitch(t), Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(roll(t), Eigen::Vector3d::UnitX());
        return s;
    }

    static ImuSample sample(std::int64_t stamp_ns) {
        const double t = static_cast<double>(stamp_ns) * 1e-9;
        const Eigen::Vector3d a_W(-2.16 * std::sin(1.2 * t), -0.81 * std::cos(0.9 * t), -2.0 * std::sin(2.0 * t));
        const double d_yaw = 0.8 + 1.2 * std::cos(2.0 * t);
        const double d_pitch = -1.2 * std::sin(3.0 * t);
        const double d_roll = 1.25 * std::cos(2.5 * t);
        const double sr = std::sin(roll(t));
        const double cr = std::cos(roll(t));
        const double sp = std::sin(pitch(t));
        const double cp = std::cos(pitch(t));
        ImuSample s;
        s.stamp = Timestamp{stamp_ns};
        s.w_B = {d_roll - d_yaw * sp, d_pitch * cr + d_yaw * cp * sr, -d_pitch * sr + d_yaw * cp * cr};
        s.a_B = state(t).q_W_B.conjugate() * (a_W - gravity_W(9.81));
        return s;
    }

    static double yaw(double t) { return 0.8 * t + 0.6 * std::sin(2.0 * t); }
    static double pitch(double t) { return 0.4 * std::cos(3.0 * t); }
    static double roll(double t) { return 0.5 * std::sin(2.5 * t); }
};

Preintegration integrate_flight(std::int64_t from_ns, std::int64_t step_ns, int steps,
                                const ImuBias& read_too_much = {}, const ImuBias& bias_lin = {}) {
    Preintegration pre(bias_lin);
    const auto biased = [&](std::int64_t t) {
        ImuSample s = WavyFlight::sample(t);
        s.w_B += read_too_much.gyro;
        s.a_B += read_too_much.accel;
        return s;
    };
    for (int k = 0; k < steps; ++k) {
        REQUIRE(ok(pre.integrate(biased(from_ns + k * step_ns), biased(from_ns + (k + 1) * step_ns), ImuNoise{})));
    }
    return pre;
}

/// Error of the predicted state after half a second of the flight, [theta p v].
Vector9 flight_error(std::int64_t step_ns) {
    constexpr std::int64_t kFrom = 300'000'000;
    const int steps = static_cast<int>(500'000'000 / step_ns);
    const NavState predicted = integrate_flight(kFrom, step_ns, steps).predict(WavyFlight::state(0.3));
    return predicted.box_minus_to(WavyFlight::state(0.8)).head<9>();
}

/// Deltas of `to` seen from `from`, [theta p v], theta on the right.
Vector9 delta_difference(const Preintegration& from, const Preintegration& to) {
    Vector9 d;
    d << so3_log(from.delta_q().conjugate() * to.delta_q()), to.delta_p() - from.delta_p(),
        to.delta_v() - from.delta_v();
    return d;
}

}  // namespace

TEST_CASE("navigation states: box_minus_to inverts box_plus") {
    std::mt19937 rng(1);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (int trial = 0; trial < 10; ++trial) {
        const auto draw = [&] { return Vector15::NullaryExpr([&](Eigen::Index) { return uniform(rng); }).eval(); };
        const NavState a = NavState{}.box_plus(draw());
        const Vector15 d = draw();
        CHECK((a.box_minus_to(a.box_plus(d)) - d).norm() < 1e-13);
    }
    // right perturbation: the turn is about the body's axis
    NavState s;
    s.q_W_B = so3_exp({0.3, -0.4, 0.5});
    Vector15 d = Vector15::Zero();
    d(kTheta + 2) = 0.2;
    CHECK((s.box_plus(d).q_W_B.toRotationMatrix() - (s.q_W_B * so3_exp({0.0, 0.0, 0.2})).toRotationMatrix()).norm() <
          1e-14);
}

TEST_CASE("constant rate and force in the body: closed form, error of second order") {
    const Eigen::Vector3d w(0.7, -1.1, 0.9);
    const Eigen::Vector3d f(1.0, -2.0, 9.5);
    constexpr double kTime_s = 0.8;
    // dv = T Gamma1 f, dp = T^2 Gamma2 f with Gamma_m = sum_n K^n / (n + m)!, K = skew(w T)
    const Eigen::Matrix3d k = skew(w * kTime_s);
    Eigen::Matrix3d gamma1 = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d gamma2 = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d power = Eigen::Matrix3d::Identity();
    double factorial = 1.0;  // n!
    for (int n = 0; n < 25; ++n) {
        gamma1 += power / (factorial * (n + 1));
        gamma2 += power / (factorial * (n + 1) * (n + 2));
        power = (power * k).eval();
        factorial *= n + 1;
    }
    const auto errors = [&](int steps) {
        Preintegration pre;
        const auto step_ns = static_cast<std::int64_t>(kTime_s * 1e9) / steps;
        for (int i = 0; i < steps; ++i) {
            REQUIRE(
                ok(pre.integrate({Timestamp{i * step_ns}, w, f}, {Timestamp{(i + 1) * step_ns}, w, f}, ImuNoise{})));
        }
        CHECK(pre.dt_s() == Approx(kTime_s).epsilon(1e-12));
        CHECK((pre.delta_q().toRotationMatrix() - so3_exp(w * kTime_s).toRotationMatrix()).norm() < 1e-12);
        return Eigen::Vector2d((pre.delta_v() - kTime_s * gamma1 * f).norm(),
                               (pre.delta_p() - kTime_s * kTime_s * gamma2 * f).norm());
    };
    const Eigen::Vector2d coarse = errors(160);
    const Eigen::Vector2d fine = errors(320);
    CHECK(coarse.maxCoeff() < 5e-5);
    CHECK(fine.x() / coarse.x() == Approx(0.25).margin(0.02));
    CHECK(fine.y() / coarse.y() == Approx(0.25).margin(0.02));
}

TEST_CASE("an analytic flight is predicted, with error of second order") {
    const Vector9 at_200_hz = flight_error(5'000'000);
    const Vector9 at_400_hz = flight_error(2'500'000);
    const Vector9 at_4_khz = flight_error(250'000);
    CHECK(at_200_hz.segment<3>(kTheta).norm() < 2e-5);
    CHECK(at_200_hz.segment<3>(kPos).norm() < 2e-5);
    CHECK(at_200_hz.segment<3>(kVel).norm() < 1e-4);
    CHECK(at_400_hz.norm() / at_200_hz.norm() == Approx(0.25).margin(0.03));
    CHECK(at_4_khz.norm() < 3e-7);
}

TEST_CASE("bias at linearization is taken off") {
    ImuBias bias;
    bias.gyro = {0.05, -0.08, 0.02};
    bias.accel = {0.2, -0.1, 0.3};
    const Preintegration clean = integrate_flight(0, 5'000'000, 100);
    const Preintegration biased = integrate_flight(0, 5'000'000, 100, bias, bias);
    CHECK(delta_difference(clean, biased).norm() < 1e-12);
    CHECK((biased.covariance() - clean.covariance()).norm() < 1e-12);
}

TEST_CASE("bias Jacobians match numeric re-integration") {
    for (const int steps : {1, 2, 40, 200}) {
        CAPTURE(steps);
        const Preintegration pre = integrate_flight(100'000'000, 5'000'000, steps);
        const auto deltas = [&](const Vector6& b) {
            return delta_difference(pre,
                                    integrate_flight(100'000'000, 5'000'000, steps, {}, {b.head<3>(), b.tail<3>()}));
        };
        test::expect_jacobian_near(pre.d_delta_d_bias(), deltas, Vector6::Zero().eval(), 1e-8, 1e-4);
    }
}

TEST_CASE("the scale of the IMU's axes turns readings into rates and forces") {
    // GIVEN readings of an IMU whose axes are off, and the correction that undoes it
    ImuScale scale;
    scale.gyro << 0.01, -0.004, 0.003, 0.002, -0.006, 0.005, -0.003, 0.004, 0.008;
    scale.accel << -0.01, 0.0, 0.0, 0.004, 0.007, 0.0, -0.005, 0.003, 0.012;
    const auto reading = [&](std::int64_t t) {
        ImuSample s = WavyFlight::sample(t);
        s.w_B = (Eigen::Matrix3d::Identity() + scale.gyro).inverse() * s.w_B;
        s.a_B = (Eigen::Matrix3d::Identity() + scale.accel).inverse() * s.a_B;
        return s;
    };
    const auto integrate = [&](const ImuScale& with) {
        Preintegration pre;
        pre.set_scale(with, true);
        for (int k = 0; k < 60; ++k) {
            REQUIRE(ok(pre.integrate(reading(k * 5'000'000), reading((k + 1) * 5'000'000), ImuNoise{})));
        }
        return pre;
    };
    // THEN the deltas are those of a perfect IMU, the Jacobian is that of integrating anew, and a change of the scale
    // is followed to first order
    const Preintegration pre = integrate(scale);
    CHECK(delta_difference(integrate_flight(0, 5'000'000, 60), pre).norm() < 1e-12);
    const auto deltas = [&](const ImuScale::Tangent& d) { return delta_difference(pre, integrate(scale.box_plus(d))); };
    test::expect_jacobian_near(pre.d_delta_d_scale(), deltas, ImuScale::Tangent::Zero().eval(), 1e-7, 1e-5);
    Eigen::Quaterniond dq;
    Eigen::Vector3d dp;
    Eigen::Vector3d dv;
    integrate({}).corrected({}, dq, dp, dv, &scale);
    CHECK((dp - pre.delta_p()).norm() < 1e-3);
    CHECK((dp - pre.delta_p()).norm() < 0.05 * (integrate({}).delta_p() - pre.delta_p()).norm());
    CHECK(so3_log(dq.conjugate() * pre.delta_q()).norm() < 1e-3);
    // AND the tangent is a tangent
    CHECK((ImuScale{}.box_plus(ImuScale{}.box_minus_to(scale)).gyro - scale.gyro).norm() == 0.0);
    CHECK((ImuScale{}.box_plus(ImuScale{}.box_minus_to(scale)).accel - scale.accel).norm() == 0.0);
}

TEST_CASE("first-order correction for the bias: the error left is of second order") {
    ImuBias bias;
    const auto error = [&](double scale) {
        bias.gyro = scale * Eigen::Vector3d(0.02, -0.01, 0.015);
        bias.accel = scale * Eigen::Vector3d(0.1, 0.05, -0.1);
        const Preintegration again = integrate_flight(0, 5'000'000, 100, {}, bias);
        Eigen::Quaterniond dq;
        Eigen::Vector3d dp;
        Eigen::Vector3d dv;
        integrate_flight(0, 5'000'000, 100).corrected(bias, dq, dp, dv);
        return so3_log(again.delta_q().conjugate() * dq).norm() + (again.delta_p() - dp).norm() +
               (again.delta_v() - dv).norm();
    };
    const double full = error(1.0);
    CHECK(full < 1e-3);
    CHECK(full > 1e-8);
    CHECK(error(0.5) / full == Approx(0.25).margin(0.05));
}

TEST_CASE("covariance matches Monte Carlo") {
    ImuNoise noise;
    noise.gyro_noise_rad_per_s_per_sqrt_hz = 1e-3;
    noise.accel_noise_m_per_s2_per_sqrt_hz = 1e-2;
    constexpr std::int64_t kStep_ns = 5'000'000;
    constexpr int kSteps = 100;
    constexpr int kRuns = 600;
    Preintegration clean;
    for (int k = 0; k < kSteps; ++k) {
        REQUIRE(ok(clean.integrate(WavyFlight::sample(k * kStep_ns), WavyFlight::sample((k + 1) * kStep_ns), noise)));
    }
    std::mt19937 rng(9);
    std::normal_distribution<double> normal;
    const double root_dt = std::sqrt(kStep_ns * 1e-9);
    const auto noisy_sample = [&](std::int64_t t) {
        ImuSample s = WavyFlight::sample(t);
        for (int axis = 0; axis < 3; ++axis) {
            s.w_B(axis) += noise.gyro_noise_rad_per_s_per_sqrt_hz / root_dt * normal(rng);
            s.a_B(axis) += noise.accel_noise_m_per_s2_per_sqrt_hz / root_dt * normal(rng);
        }
        return s;
    };
    Matrix9 scatter = Matrix9::Zero();
    for (int run = 0; run < kRuns; ++run) {
        Preintegration noisy;
        ImuSample previous = noisy_sample(0);
        for (int k = 1; k <= kSteps; ++k) {
            const ImuSample next = noisy_sample(k * kStep_ns);
            REQUIRE(ok(noisy.integrate(previous, next, noise)));
            previous = next;
        }
        const Vector9 d = delta_difference(clean, noisy);
        scatter += d * d.transpose() / kRuns;
    }
    // whitened by the predicted covariance the scatter is the identity; standard error 1 / sqrt(600) = 0.04 off the
    // diagonal, 0.06 on it
    const Matrix9 L = clean.covariance().llt().matrixL();
    const Matrix9 inverse = L.inverse();
    const Matrix9 whitened = inverse * scatter * inverse.transpose();
    CAPTURE(whitened);
    CHECK((whitened - Matrix9::Identity()).cwiseAbs().maxCoeff() < 0.2);
    CHECK(whitened.trace() / 9.0 == Approx(1.0).margin(0.07));
}

TEST_CASE("covariance is positive definite from the first step on and does not depend on the sampling rate") {
    const Preintegration one = integrate_flight(0, 5'000'000, 1);
    const Eigen::LLT<Matrix9> llt(one.covariance());
    CHECK(llt.info() == Eigen::Success);
    CHECK(llt.matrixLLT().diagonal().minCoeff() > 0.0);
    const Matrix9 slow = integrate_flight(0, 5'000'000, 100).covariance();
    const Matrix9 fast = integrate_flight(0, 1'000'000, 500).covariance();
    CHECK((slow - slow.transpose()).norm() == 0.0);
    for (int k = 0; k < 9; ++k) {
        CHECK(slow(k, k) == Approx(fast(k, k)).epsilon(0.01));
    }
}

TEST_CASE("a resting IMU stays where it is, a falling one falls") {
    const double g = GENERATE(9.78, 9.81);
    Preintegration rest({}, g);
    Preintegration fall({}, g);
    fall.reset({});  // keeps its gravity
    for (std::int64_t k = 0; k < 200; ++k) {
        const Timestamp a{k * 5'000'000};
        const Timestamp b{(k + 1) * 5'000'000};
        const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
        REQUIRE(ok(rest.integrate({a, zero, -gravity_W(g)}, {b, zero, -gravity_W(g)}, ImuNoise{})));
        REQUIRE(ok(fall.integrate({a, zero, zero}, {b, zero, zero}, ImuNoise{})));
    }
    NavState start;
    start.p_W_B = {1.0, 2.0, 3.0};
    CHECK(start.box_minus_to(rest.predict(start)).norm() < 1e-12);
    const NavState fallen = fall.predict(start);
    CHECK(fallen.p_W_B.z() == Approx(3.0 - 0.5 * g));
    CHECK(fallen.v_W_B.z() == Approx(-g));
}

TEST_CASE("prediction uses and carries over the bias of the state") {
    NavState start = WavyFlight::state(0.0);
    start.bias.gyro = {0.01, -0.02, 0.03};
    start.bias.accel = {0.05, 0.1, -0.05};
    const Preintegration pre = integrate_flight(0, 5'000'000, 40, start.bias);  // linearised at zero bias
    const NavState end = pre.predict(start);
    CHECK(end.bias.gyro == start.bias.gyro);
    CHECK(end.bias.accel == start.bias.accel);
    const NavState truth = WavyFlight::state(0.2);
    CHECK((end.p_W_B - truth.p_W_B).norm() < 1e-4);
    CHECK((end.v_W_B - truth.v_W_B).norm() < 1e-3);
    CHECK(end.q_W_B.angularDistance(truth.q_W_B) < 1e-4);
}

TEST_CASE("steps backwards or of no length are refused and leave the sums alone; reset restarts") {
    Preintegration pre = integrate_flight(0, 5'000'000, 10);
    const Preintegration before = pre;
    const ImuSample a = WavyFlight::sample(10);
    const ImuSample b = WavyFlight::sample(20);
    CHECK(pre.integrate(b, a, ImuNoise{}) == Status::kOutOfOrder);
    CHECK(pre.integrate(a, a, ImuNoise{}) == Status::kOutOfOrder);
    CHECK(delta_difference(before, pre).norm() == 0.0);
    CHECK(pre.dt_s() == before.dt_s());
    ImuBias bias;
    bias.gyro.x() = 0.1;
    pre.reset(bias);
    CHECK(pre.dt_s() == 0.0);
    CHECK(pre.bias().gyro.x() == 0.1);
    CHECK(pre.covariance().norm() == 0.0);
    CHECK(pre.d_delta_d_bias().norm() == 0.0);
    CHECK(delta_difference(Preintegration{}, pre).norm() == 0.0);
}

}  // namespace facet::preintegration_test
