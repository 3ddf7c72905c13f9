// SPDX-License-Identifier: BSD-2-Clause
// Weights as the paper's authors have published them, in its three modes.
#include "estimator/window/published_weights.h"

#include <catch2/catch.hpp>
#include <memory>

#include "estimator/window/window.h"
#include "tests/support/synthetic_flight.h"

namespace facet::published_weights_test {

using facet::test::SyntheticFlight;

namespace {

constexpr double kStep_s = 0.2;

/// A window at the end of a noisy flight through a room whose walls are proposed as planes.
std::unique_ptr<Window> fly(RegularityMode mode, bool published, double duration_s = 3.0) {
    SyntheticFlight::Options options;
    options.pixel_sigma = 0.5;
    options.in_room = true;
    SyntheticFlight flight(options);
    WindowConfig config;
    config.keyframes = 8;
    config.published_weights = published;
    CalibrationConfig calibration;
    calibration.estimate_cameras = calibration.estimate_time_offset = false;
    RegularityConfig regularity;
    regularity.mode = mode;
    regularity.use_gravity = !published;
    const ImuNoise noise = test::euroc_like_noise();
    auto window = std::make_unique<Window>();
    window->configure(config, calibration, flight.rig(), noise, regularity);
    const Eigen::Matrix<double, kStateDim, kStateDim> information =
        test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
    const auto first = flight.observe(0.0);
    window->start({test::at(0.0), Eigen::Vector3d::Zero(), false, {first.data(), first.size()}}, flight.state(0.0),
                  information);
    for (double t = kStep_s; t < duration_s; t += kStep_s) {
        const Preintegration p = flight.preintegrate(t - kStep_s, t, window->newest().state.bias, noise);
        const auto observations = flight.observe(t);
        window->set_planes(flight.planes());
        REQUIRE(ok(
            window->add_keyframe({test::at(t), flight.rate(t), false, {observations.data(), observations.size()}}, p)));
        REQUIRE_FALSE(window->optimize().solver.solver_failed);
    }
    return window;
}

Eigen::Vector3d place(const Window& window) { return window.newest().state.p_W_B; }

}  // namespace

TEST_CASE("a landmark's projection factors are narrower than structureless ones", "[published_weights]") {
    const auto window = fly(RegularityMode::kSp, true);
    Landmark landmark;
    const RobustLoss structureless = window->cameras().loss(landmark);
    landmark.is_projected = true;
    const RobustLoss projected = window->cameras().loss(landmark);
    CHECK(window->cameras().geometry().scale == Approx(1.0 / 3.0));
    CHECK(structureless.weight(1e4) == 1.0);
    CHECK(projected.weight(0.0) == Approx(9.0 / (1.8 * 1.8)));
    const double edge_px = 4.6851 * 1.8;
    CHECK(projected.weight(std::pow(0.99 * edge_px / 3.0, 2)) > 0.0);
    CHECK(projected.weight(std::pow(1.01 * edge_px / 3.0, 2)) == 0.0);
}

TEST_CASE("weights as published are not learned, while the residuals are measured", "[published_weights]") {
    const auto published = fly(RegularityMode::kS, true);
    CHECK(published->cameras().noise().sigma_px() == PublishedWeights::kStructureless_px);
    CHECK(published->cameras().noise().measured_px() == Approx(0.5).margin(0.15));
    const auto ours = fly(RegularityMode::kS, false);
    CHECK(ours->cameras().noise().sigma_px() != WindowConfig{}.pixel_sigma_px);
}

TEST_CASE("as published sp differs from s by its weights, otherwise not at all", "[published_weights]") {
    CHECK(place(*fly(RegularityMode::kSp, false)) == place(*fly(RegularityMode::kS, false)));
    const Eigen::Vector3d s = place(*fly(RegularityMode::kS, true));
    const Eigen::Vector3d sp = place(*fly(RegularityMode::kSp, true));
    CHECK((sp - s).norm() > 1e-6);
    CHECK((sp - s).norm() < 0.05);
}

TEST_CASE("as published only spr holds planes, each height as if it were independent", "[published_weights]") {
    CHECK(fly(RegularityMode::kSp, true)->state().planes.empty());
    const auto window = fly(RegularityMode::kSpr, true);
    CHECK_FALSE(window->state().planes.empty());
    const RegularityConfig regularity = PublishedWeights::of_regularities({.published_weights = true}, {});
    CHECK(regularity.weigh_m(500) == PublishedWeights::kRegularity_m);
}

}  // namespace facet::published_weights_test
