// SPDX-License-Identifier: BSD-2-Clause
// Propagated covariance against a Monte Carlo of the prediction itself.
#include "estimator/imu/propagation.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace facet::propagation_test {
namespace {

using Vector15 = Eigen::Matrix<double, kStateDim, 1>;

struct Trial {
    ImuNoise noise;
    std::mt19937 generator{7};
    std::normal_distribution<double> normal;

    Eigen::Vector3d gaussian() {
        const double x = normal(generator);
        const double y = normal(generator);
        const double z = normal(generator);
        return {x, y, z};
    }
    ImuSample sample(int k, const ImuBias& bias, bool noisy) {
        const double t = 0.005 * k;
        const double root_rate = noisy ? std::sqrt(200.0) : 0.0;
        ImuSample s;
        s.stamp = Timestamp{} + Duration::from_seconds(10.0 + t);
        s.w_B = Eigen::Vector3d(0.5, -0.8 + t, 0.3) + bias.gyro +
                noise.gyro_noise_rad_per_s_per_sqrt_hz * root_rate * gaussian();
        s.a_B = Eigen::Vector3d(1.0, 0.5 * t, 9.0) + bias.accel +
                noise.accel_noise_m_per_s2_per_sqrt_hz * root_rate * gaussian();
        return s;
    }
    Preintegration integrate(const ImuBias& true_bias, const ImuBias& used_bias, bool noisy) {
        Preintegration p(used_bias);
        ImuSample a = sample(0, true_bias, noisy);
        for (int k = 1; k <= 100; ++k) {
            const ImuSample b = sample(k, true_bias, noisy);
            REQUIRE(ok(p.integrate(a, b, noise)));
            a = b;
        }
        return p;
    }
};

}  // namespace

TEST_CASE("a propagated covariance is that of predictions from wrong states with noisy samples", "[propagation]") {
    Trial trial;
    trial.noise.gyro_noise_rad_per_s_per_sqrt_hz = 5e-3;
    trial.noise.accel_noise_m_per_s2_per_sqrt_hz = 3e-2;
    NavState truth;
    truth.q_W_B = so3_exp({0.4, -0.3, 1.0});
    truth.v_W_B = {1.0, -0.5, 0.2};
    Vector15 sigma;
    sigma << 0.01, 0.02, 0.03, 0.01, 0.02, 0.01, 0.05, 0.03, 0.04, 0.01, 0.02, 0.01, 0.05, 0.1, 0.05;
    const StateCovariance before = sigma.cwiseAbs2().asDiagonal();
    const NavState after = trial.integrate(truth.bias, truth.bias, false).predict(truth);
    const StateCovariance propagated =
        propagate_covariance(truth, before, trial.integrate(truth.bias, truth.bias, false), trial.noise);

    constexpr int kRuns = 3000;
    double nees = 0.0;
    StateCovariance measured = StateCovariance::Zero();
    const Eigen::LLT<StateCovariance> llt(propagated);
    for (int run = 0; run < kRuns; ++run) {
        Vector15 d;
        for (int i = 0; i < kStateDim; ++i) {
            d(i) = sigma(i) * trial.normal(trial.generator);
        }
        const NavState wrong = truth.box_plus(d);
        const NavState predicted = trial.integrate(truth.bias, wrong.bias, true).predict(wrong);
        const Vector15 error = after.box_minus_to(predicted);
        nees += error.dot(llt.solve(error)) / kRuns;
        measured += error * error.transpose() / kRuns;
    }
    // The walk of the biases is in the propagated covariance only, and small.
    CHECK(nees == Approx(kStateDim).epsilon(0.08));
    for (int i = 0; i < kStateDim; ++i) {
        CHECK(measured(i, i) == Approx(propagated(i, i)).epsilon(0.12));
    }
}

TEST_CASE("the biases' walk over seconds is that of many short intervals", "[propagation]") {
    ImuNoise noise;
    noise.gyro_walk_rad_per_s2_per_sqrt_hz = 1e-4;
    noise.accel_walk_m_per_s3_per_sqrt_hz = 3e-3;
    constexpr int kSteps = 1000;
    constexpr double kStep_s = 0.005;
    const auto sample = [](int k) {
        ImuSample s;
        s.stamp = Timestamp{} + Duration::from_seconds(10.0 + kStep_s * k);
        s.a_B = {0.5, -0.3, 9.81};
        return s;
    };
    NavState state;
    state.q_W_B = so3_exp({0.1, -0.2, 1.0});
    const NavState begin = state;
    StateCovariance chained = StateCovariance::Zero();
    Preintegration whole(state.bias);
    for (int k = 0; k < kSteps; ++k) {
        Preintegration step(state.bias);
        REQUIRE(ok(step.integrate(sample(k), sample(k + 1), noise)));
        REQUIRE(ok(whole.integrate(sample(k), sample(k + 1), noise)));
        chained = propagate_covariance(state, chained, step, noise);
        state = step.predict(state);
    }
    const StateCovariance at_once = propagate_covariance(begin, StateCovariance::Zero(), whole, noise);
    const Vector15 sigma = chained.diagonal().cwiseSqrt();
    const StateCovariance difference =
        sigma.cwiseInverse().asDiagonal() * (at_once - chained) * sigma.cwiseInverse().asDiagonal();
    CHECK(difference.cwiseAbs().maxCoeff() < 0.01);
    // It is most of what is not known of place and velocity by then.
    CHECK(whole.covariance()(kPos, kPos) < 0.3 * at_once(kPos, kPos));
}

}  // namespace facet::propagation_test
