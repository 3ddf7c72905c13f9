// SPDX-License-Identifier: BSD-2-Clause
// Readings of a range finder in the window: which belong together, and what they do.
#include "estimator/window/ground_levels.h"

#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <vector>

#include "estimator/window/window.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/synthetic_flight.h"

namespace facet::ground_levels_test {

using facet::test::SyntheticFlight;

namespace {

using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;

const RangeConfig kOn{.enabled = true, .sigma_m = 0.02};
constexpr double kClimbSigma_m_per_s = 0.02;
constexpr double kStep_s = 0.2;
constexpr double kSpeed_m_per_s = 0.3;
constexpr int kLandmarks = 12;  // so few that height drifts

/// A vehicle that flies ahead at 1 m/s and 1.5 m over a floor on which things of these heights stand.
std::unique_ptr<WindowState> fly_over(const std::vector<double>& heights_m, double height_m = 1.5) {
    auto state = std::make_unique<WindowState>();
    state->has_ground = true;
    state->prior.reset(1, PriorFactor::kMaxGround);
    for (std::size_t k = 0; k < heights_m.size(); ++k) {
        Keyframe keyframe;
        const double t = kStep_s * static_cast<double>(k);
        keyframe.stamp = test::at(t);
        keyframe.state.p_W_B = {t, 0.0, height_m};
        state->keyframes.push_back(keyframe);
        add_ground_reading(kOn, 0, {0.0, 0.0, heights_m[k] - height_m}, kClimbSigma_m_per_s, *state);
    }
    return state;
}

std::vector<int> levels(const WindowState& state) {
    std::vector<int> all;
    for (const Keyframe& keyframe : state.keyframes) {
        all.push_back(keyframe.ground.level);
    }
    return all;
}

/// Largest error of the height, and what is claimed of the last one's.
struct Outcome {
    double worst_change_m = 0.0;  ///< of height since the start
    double sigma_m = 0.0;
    double last_m = 0.0;
    bool doubts = false;
};

/// @param ground_m  height of the ground under a place
template <class Ground>
Outcome fly(const RangeConfig& config, Ground ground_m, double duration_s, double place_sigma_m = 1e-3) {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = 0.5;
    options.motion.velocity_m_per_s = {kSpeed_m_per_s, 0.0, 0.0};
    SyntheticFlight flight(options);
    const ImuNoise noise = test::euroc_like_noise();
    WindowConfig window_config;
    window_config.keyframes = 10;
    window_config.pixel_sigma_px = 0.5;
    const auto window = std::make_unique<Window>();
    window->configure(window_config, {}, flight.rig(), noise, {}, config);
    Eigen::Matrix<double, kStateDim, 1> sigmas = test::start_sigmas();
    sigmas.segment<3>(kPos).setConstant(place_sigma_m);
    std::mt19937 generator(5);
    std::normal_distribution<double> normal(0.0, config.sigma_m);
    const auto reading = [&](double t) {
        const NavState truth = flight.state(t);
        const double above_m = truth.p_W_B.z() + 4.0 - ground_m(truth.p_W_B) + normal(generator);
        const Eigen::Vector3d down_B = truth.q_W_B.conjugate() * -Eigen::Vector3d::UnitZ();
        return Eigen::Vector3d(above_m * down_B);
    };
    auto seen = flight.observe(0.0, kLandmarks);
    KeyframeInput input{test::at(0.0), flight.rate(0.0), false, {seen.data(), seen.size()}};
    input.ground_B = reading(0.0);
    window->start(input, flight.state(0.0), StateMatrix(sigmas.cwiseAbs2().cwiseInverse().asDiagonal()));
    Outcome outcome;
    for (double t = kStep_s; t <= duration_s + 1e-9; t += kStep_s) {
        const Preintegration p = flight.preintegrate(t - kStep_s, t, window->newest().state.bias, noise);
        seen = flight.observe(t, kLandmarks);
        KeyframeInput next{test::at(t), flight.rate(t), false, {seen.data(), seen.size()}};
        next.ground_B = reading(t);
        next.climb_sigma_m_per_s = kClimbSigma_m_per_s;
        const test::AllocationGuard guard;
        const Status status = window->add_keyframe(next, p);
        const WindowSummary summary = window->optimize();
        const std::uint64_t allocations = guard.allocations();
        REQUIRE(ok(status));
        REQUIRE(allocations == 0);
        REQUIRE_FALSE(summary.solver.solver_failed);
        REQUIRE_FALSE(summary.marginalization_failed);
        outcome.doubts = outcome.doubts || window->doubts_ground();
        outcome.last_m = window->newest().state.p_W_B.z() - flight.state(t).p_W_B.z();
        outcome.worst_change_m = std::max(outcome.worst_change_m, std::abs(outcome.last_m));
    }
    StateMatrix covariance;
    REQUIRE(ok(window->newest_covariance(covariance)));
    outcome.sigma_m = std::sqrt(covariance(kPos + 2, kPos + 2));
    return outcome;
}

const auto kFloor = [](const Eigen::Vector3d&) { return 0.0; };

}  // namespace

TEST_CASE("readings of one floor are of one level", "[ground]") {
    CHECK(levels(*fly_over({0.0, 0.01, -0.02, 0.0})) == std::vector<int>{0, 0, 0, 0});
}

TEST_CASE("an edge begins a new level, and behind it the old one goes on", "[ground]") {
    CHECK(levels(*fly_over({0.0, 0.0, 0.7, 0.71, 0.7, 0.0, 0.01})) == std::vector<int>{0, 0, 1, 1, 1, 0, 0});
    // A single wrong reading is a level by itself, which says nothing.
    CHECK(levels(*fly_over({0.0, 0.0, 1.2, 0.0})) == std::vector<int>{0, 0, 1, 0});
}

TEST_CASE("steps of stairs are levels of their own", "[ground]") {
    // There is room for three: the oldest gives way, with its reading.
    CHECK(levels(*fly_over({0.0, 0.18, 0.36, 0.54})) == std::vector<int>{GroundReading::kNone, 1, 2, 0});
}

TEST_CASE("a level left long ago is not known again", "[ground]") {
    const auto state = fly_over({0.0, 0.0});
    const auto fly_on = [&](double t) {
        Keyframe keyframe;
        keyframe.stamp = test::at(t);
        keyframe.state.p_W_B = {0.0, 0.0, 1.5};
        state->keyframes.push_back(keyframe);
        add_ground_reading(kOn, 0, {0.0, 0.0, -1.5}, kClimbSigma_m_per_s, *state);
        return state->keyframes.back().ground.level;
    };
    CHECK(fly_on(9.0) == 0);
    CHECK(fly_on(19.5) == 1);
}

TEST_CASE("what the prior knows of a level wanders with the way over it, and is forgotten with the level", "[ground]") {
    const auto state = fly_over({0.0});
    state->prior.h()(0, 0) = 1e4;  // known to 1 cm
    Keyframe keyframe;
    keyframe.stamp = test::at(kStep_s);
    keyframe.state.p_W_B = {1.0, 0.0, 1.5};
    state->keyframes.push_back(keyframe);
    add_ground_reading(kOn, 0, {0.0, 0.0, -1.5}, kClimbSigma_m_per_s, *state);
    const double variance = 1e-4 + RangeConfig::kUnevenness * RangeConfig::kUnevenness;
    CHECK(state->prior.h()(0, 0) == Approx(1.0 / variance));
    // WHEN five readings lie far from their level THEN it is forgotten
    for (int i = 0; i < 3; ++i) {
        keyframe.stamp = test::at(kStep_s * (2 + i));
        state->keyframes.push_back(keyframe);
        add_ground_reading(kOn, 0, {0.0, 0.0, -1.5}, kClimbSigma_m_per_s, *state);
    }
    CHECK_FALSE(drop_uneven_ground(kOn, 0, *state));
    state->ground[0].height_m = 0.05;
    CHECK(drop_uneven_ground(kOn, 0, *state));
    CHECK(levels(*state) == std::vector<int>(5, GroundReading::kNone));
    CHECK_FALSE(state->ground[0].is_known);
    CHECK(state->prior.h()(0, 0) < 1e-5);
}

TEST_CASE("readings hold changes of height over level ground", "[ground]") {
    const Outcome without = fly({}, kFloor, 60.0);
    const Outcome with = fly(kOn, kFloor, 60.0);
    CAPTURE(without.worst_change_m, with.worst_change_m, without.sigma_m, with.sigma_m);
    CHECK_FALSE(with.doubts);
    CHECK(with.sigma_m < 0.8 * without.sigma_m);
    CHECK(with.worst_change_m < without.worst_change_m);
    CHECK(std::abs(with.last_m) < 3.0 * with.sigma_m);
}

TEST_CASE("tables on the way do no harm", "[ground]") {
    const auto table = [](const Eigen::Vector3d& p) { return std::fmod(p.x() + 100.0, 1.5) < 0.5 ? 0.7 : 0.0; };
    const Outcome without = fly({}, table, 20.0);
    const Outcome with = fly(kOn, table, 20.0);
    CHECK(with.worst_change_m < without.worst_change_m + 0.01);
    CHECK(std::abs(with.last_m) < 3.0 * with.sigma_m);
}

TEST_CASE("a ramp is doubted, and followed by a small part of what it rises", "[ground]") {
    constexpr double kSlope = 0.12;
    constexpr double kDuration_s = 20.0;
    const auto ramp = [](const Eigen::Vector3d& p) { return kSlope * p.x(); };
    const Outcome with = fly(kOn, ramp, kDuration_s);
    CHECK(with.doubts);
    CHECK(with.worst_change_m < 0.3 * kSlope * kSpeed_m_per_s * kDuration_s);  // measured: 0.13 of 0.72 m
}

TEST_CASE("readings teach nothing of the height itself", "[ground]") {
    const Outcome loose = fly(kOn, kFloor, 20.0, 0.5);
    CHECK(loose.sigma_m > 0.9 * 0.5);
}

TEST_CASE("without the option readings change no bit", "[ground]") {
    RangeConfig off = kOn;
    off.enabled = false;
    const auto table = [](const Eigen::Vector3d& p) { return p.x() > 1.0 ? 0.7 : 0.0; };
    const Outcome a = fly(off, kFloor, 6.0);
    const Outcome b = fly(off, table, 6.0);
    CHECK(a.last_m == b.last_m);
    CHECK(a.sigma_m == b.sigma_m);
}

}  // namespace facet::ground_levels_test
