// SPDX-License-Identifier: BSD-2-Clause
// A vehicle that stands for a minute: no drift, no churn of keyframes, no false certainty.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

#include "estimator/window/window.h"
#include "tests/support/synthetic_flight.h"

namespace facet::standing_test {

using facet::test::SyntheticFlight;

namespace {

using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;
using StateVector = Eigen::Matrix<double, kStateDim, 1>;

constexpr double kStep_s = 1.0;

/// The pose of a synthetic flight at time 0, kept.
struct Standing {
    SyntheticFlight flight;
    ImuNoise noise;
    NavState truth;
    std::mt19937 generator{11};
    std::normal_distribution<double> normal;
    std::unique_ptr<Window> window = std::make_unique<Window>();
    WindowConfig config;

    static SyntheticFlight::Options options() {
        SyntheticFlight::Options o;
        o.pixel_sigma = 0.5;
        return o;
    }
    Standing() : flight(options()), truth(flight.state(0.0)) {
        truth.v_W_B.setZero();
        truth.bias = {};
        config.keyframes = 12;
        window->configure(config, {}, flight.rig(), noise);
        StateVector sigma;
        sigma << 0.02, 0.02, 1e-4, 1e-4, 1e-4, 1e-4, 0.05, 0.05, 0.05, 0.005, 0.005, 0.005, 0.1, 0.1, 0.1;
        const auto seen = flight.observe(0.0);
        window->start({test::at(0.0), Eigen::Vector3d::Zero(), false, {seen.data(), seen.size()}}, truth,
                      sigma.cwiseAbs2().cwiseInverse().asDiagonal());
    }
    Eigen::Vector3d gaussian() {
        const double x = normal(generator);
        const double y = normal(generator);
        const double z = normal(generator);
        return {x, y, z};
    }
    ImuSample sample(double t) {
        const double root_rate = std::sqrt(200.0);
        return {test::at(t), noise.gyro_noise_rad_per_s_per_sqrt_hz * root_rate * gaussian(),
                truth.q_W_B.conjugate() * (-gravity_W(9.81)) +
                    noise.accel_noise_m_per_s2_per_sqrt_hz * root_rate * gaussian()};
    }
    void stand(int from, int to, bool is_known_to_rest) {
        for (int k = from; k <= to; ++k) {
            Preintegration p(window->newest().state.bias);
            ImuSample a = sample(kStep_s * (k - 1));
            for (int i = 1; i <= 200; ++i) {
                const ImuSample b = sample(kStep_s * (k - 1) + 0.005 * i);
                REQUIRE(ok(p.integrate(a, b, noise)));
                a = b;
            }
            const auto seen = flight.observe(0.0);  // the same view, fresh noise
            REQUIRE(ok(window->add_keyframe(
                {test::at(kStep_s * k), Eigen::Vector3d::Zero(), is_known_to_rest, {seen.data(), seen.size()}}, p)));
            const WindowSummary summary = window->optimize();
            REQUIRE_FALSE(summary.solver.solver_failed);
            REQUIRE_FALSE(summary.marginalization_failed);
        }
    }
    StateMatrix covariance() {
        StateMatrix c;
        REQUIRE(ok(window->newest_covariance(c)));
        return c;
    }
};

}  // namespace

TEST_CASE("a minute of standing: in place, with the first keyframe still in the window", "[standing]") {
    Standing s;
    const bool is_known_to_rest = GENERATE(true, false);  // false: hovering, as far as the window can tell
    CAPTURE(is_known_to_rest);
    s.stand(1, 6, is_known_to_rest);
    const StateMatrix early = s.covariance();
    s.stand(7, 60, is_known_to_rest);
    const StateMatrix late = s.covariance();
    const StateVector error = s.truth.box_minus_to(s.window->newest().state);
    CHECK(error.segment<3>(kPos).norm() < 0.01);
    CHECK(error.segment<3>(kTheta).norm() < 0.0017);
    CHECK(error.segment<3>(kVel).norm() < 0.01);
    CHECK(s.window->state().keyframes.front().stamp == test::at(0.0));

    // Standing longer makes neither place nor yaw surer than what one look gives.
    CHECK(late.diagonal().segment<3>(kPos).norm() > 0.5 * early.diagonal().segment<3>(kPos).norm());
    const double sure = std::sqrt(late.diagonal().segment<3>(kPos).maxCoeff());
    CHECK(sure > 2e-4);
    CHECK(error.segment<3>(kPos).norm() < 5.0 * std::sqrt(late.diagonal().segment<3>(kPos).sum()));
}

TEST_CASE("dropping a keyframe keeps every observation at its keyframe", "[standing]") {
    Standing s;
    s.stand(1, 15, true);
    const WindowState& state = s.window->state();
    const int keyframes = static_cast<int>(state.keyframes.size());
    int observations = 0;
    for (int i = 0; i < state.landmarks.size(); ++i) {
        int before = -1;
        for (const LandmarkObservation& o : state.landmarks[i].observations) {
            CHECK(o.keyframe > before);
            CHECK(o.keyframe < keyframes);
            before = o.keyframe;
            ++observations;
        }
    }
    CHECK(observations > 50 * keyframes);
    for (int k = 1; k < keyframes; ++k) {
        CHECK(state.keyframes[static_cast<std::size_t>(k)].stamp >
              state.keyframes[static_cast<std::size_t>(k - 1)].stamp);
    }
    CHECK(state.prior.keyframes() == keyframes - 1);  // the newest came after
    CHECK(state.keyframes.back().has_imu_factor);
}

}  // namespace facet::standing_test
