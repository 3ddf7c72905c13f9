// SPDX-License-Identifier: BSD-2-Clause
// Failures inside the window, injected: each leaves a window that goes on, and says that something was wrong.
#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "estimator/window/window.h"
#include "tests/support/synthetic_flight.h"

namespace facet::failure_test {

using facet::test::SyntheticFlight;

namespace {

constexpr double kStep_s = 0.2;
constexpr int kKeyframes = 8;

/// A flight through a small window, in which `spoil` gets at the window's contents after some keyframes.
struct Spoilt {
    std::unique_ptr<Window> window = std::make_unique<Window>();
    int marginalization_failures = 0;
    int replacements = 0;
    int solver_failures = 0;
    double error_m = 0.0;  ///< at the end
    bool covariance_is_finite = true;

    Spoilt(int at, int keyframes, const std::function<void(WindowState&)>& spoil) {
        SyntheticFlight::Options options;
        options.gyro_noise = 1.7e-4;
        options.accel_noise = 2e-3;
        options.pixel_sigma = 0.3;
        SyntheticFlight flight(options);
        const ImuNoise noise = test::euroc_like_noise();
        WindowConfig config;
        config.keyframes = kKeyframes;
        window->configure(config, {}, flight.rig(), noise);
        const auto first = flight.observe(0.0);
        const Eigen::Matrix<double, kStateDim, kStateDim> information =
            test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
        window->start({test::at(0.0), Eigen::Vector3d::Zero(), false, {first.data(), first.size()}}, flight.state(0.0),
                      information);
        for (int k = 1; k <= keyframes; ++k) {
            const double t = kStep_s * k;
            const Preintegration p = flight.preintegrate(t - kStep_s, t, window->newest().state.bias, noise);
            if (k == at) {
                spoil(const_cast<WindowState&>(window->state()));
            }
            const auto seen = flight.observe(t);
            REQUIRE(ok(window->add_keyframe({test::at(t), flight.rate(t), false, {seen.data(), seen.size()}}, p)));
            const WindowSummary summary = window->optimize();
            marginalization_failures += summary.marginalization_failed ? 1 : 0;
            replacements += summary.prior_replaced ? 1 : 0;
            solver_failures += summary.solver.solver_failed ? 1 : 0;
            const WindowState& state = window->state();
            REQUIRE(state.keyframes.size() <= kKeyframes);
            REQUIRE(state.prior.keyframes() >= 1);
            REQUIRE(state.prior.keyframes() <= static_cast<int>(state.keyframes.size()));
            Eigen::Matrix<double, kStateDim, kStateDim> covariance;
            const bool is_known = ok(window->newest_covariance(covariance));
            covariance_is_finite = is_known && covariance.allFinite();
        }
        error_m = (window->newest().state.p_W_B - flight.state(kStep_s * keyframes).p_W_B).norm();
    }
};

}  // namespace

TEST_CASE("without a failure there is none", "[failure]") {
    const Spoilt run(0, 30, [](WindowState&) {});
    CHECK(run.marginalization_failures + run.replacements + run.solver_failures == 0);
    CHECK(run.error_m < 0.03);
}

TEST_CASE("a keyframe that cannot be marginalized goes without its prior, and the window goes on", "[failure]") {
    const Spoilt run(15, 45, [](WindowState& state) {
        // So much negative information on the oldest keyframe that its block is not positive definite.
        const int at = state.prior.globals();
        state.prior.h().block<kStateDim, kStateDim>(at, at).diagonal().array() -= 1e16;
    });
    CHECK(run.marginalization_failures >= 1);
    CHECK(run.marginalization_failures <= 3);
    CHECK(run.solver_failures == 0);
    CHECK(run.covariance_is_finite);
    CHECK(run.error_m < 0.3);
}

TEST_CASE("an indefinite prior between marginalizations is replaced", "[failure]") {
    const Spoilt run(4, 30, [](WindowState& state) {  // long before the window is full
        const int at = state.prior.globals();
        state.prior.h().block<kStateDim, kStateDim>(at, at).diagonal().array() -= 1e16;
    });
    CHECK(run.replacements >= 1);
    CHECK(run.replacements <= 3);
    CHECK(run.covariance_is_finite);
    CHECK(run.error_m < 0.3);
}

TEST_CASE("a prior that is NaN is replaced", "[failure]") {
    const int at = GENERATE(4, 15);
    CAPTURE(at);
    const Spoilt run(at, 45, [](WindowState& state) {
        state.prior.h()(0, 0) = state.prior.g()(0) = std::numeric_limits<double>::quiet_NaN();
    });
    CHECK(run.marginalization_failures + run.replacements >= 1);
    CHECK(run.covariance_is_finite);
    CHECK(run.error_m < 0.3);
}

TEST_CASE("a store without room for landmarks rejects new ones, and the window goes on", "[failure]") {
    const Spoilt run(12, 30, [](WindowState& state) {
        for (std::uint32_t id = 1'000'000; state.landmarks.find_or_insert(LandmarkId{id}) != nullptr; ++id) {
        }
        REQUIRE(state.landmarks.size() == kMaxLandmarks);
    });
    CHECK(run.solver_failures == 0);
    CHECK(run.covariance_is_finite);
    CHECK(run.error_m < 0.3);
}

}  // namespace facet::failure_test
