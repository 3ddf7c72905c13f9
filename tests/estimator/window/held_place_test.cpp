// SPDX-License-Identifier: BSD-2-Clause
// A window that knows its yaw and place badly and takes them for known, next to one that does not.
#include <catch2/catch.hpp>
#include <memory>

#include "estimator/window/window.h"
#include "tests/support/synthetic_flight.h"

using namespace facet;
using facet::test::SyntheticFlight;

namespace {

using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;

/// A window that has begun half a metre unsure of its place, flown by keyframes of a noisy flight.
struct Flight {
    Flight() {
        WindowConfig config;
        config.keyframes = 10;
        config.pixel_sigma_px = 0.5;
        window->configure(config, {}, flight.rig(), noise);
        Eigen::Matrix<double, kStateDim, 1> sigmas = test::start_sigmas();
        sigmas.segment<3>(kPos).setConstant(0.5);
        const auto seen = flight.observe(0.0);
        window->start({test::at(0.0), flight.rate(0.0), false, {seen.data(), seen.size()}}, flight.state(0.0),
                      StateMatrix(sigmas.cwiseAbs2().cwiseInverse().asDiagonal()));
    }
    void fly(double step_s) {
        const Preintegration p = flight.preintegrate(now_s, now_s + step_s, window->newest().state.bias, noise);
        now_s += step_s;
        const auto seen = flight.observe(now_s);
        REQUIRE(ok(window->add_keyframe({test::at(now_s), flight.rate(now_s), false, {seen.data(), seen.size()}}, p)));
        REQUIRE_FALSE(window->optimize().solver.solver_failed);
        REQUIRE(ok(window->newest_covariance(covariance)));
    }
    double place_sigma_m() const { return std::sqrt(covariance.diagonal().segment<3>(kPos).maxCoeff()); }

    static SyntheticFlight::Options noisy() {
        SyntheticFlight::Options options;
        options.gyro_noise = 1.7e-4;
        options.accel_noise = 2e-3;
        options.pixel_sigma = 0.5;
        return options;
    }
    SyntheticFlight flight{noisy()};
    ImuNoise noise = test::euroc_like_noise();
    std::unique_ptr<Window> window = std::make_unique<Window>();
    double now_s = 0.0;
    StateMatrix covariance = StateMatrix::Zero();
};

}  // namespace

TEST_CASE("a window that holds its place knows it, and all else as well as before", "[window]") {
    Flight loose;
    Flight held;
    for (int k = 0; k < 25; ++k) {
        loose.fly(0.2);
        held.fly(0.2);
    }
    REQUIRE(held.place_sigma_m() > 0.4);
    const Eigen::Vector3d before = held.window->newest().state.p_W_B;
    REQUIRE(ok(held.window->hold_place()));
    loose.fly(0.2);
    held.fly(0.2);
    CHECK(loose.place_sigma_m() > 0.4);
    CHECK(held.place_sigma_m() < 0.02);
    const NavState& a = loose.window->newest().state;
    const NavState& b = held.window->newest().state;
    CHECK((a.p_W_B - b.p_W_B).norm() < 0.01);  // which is the loose one's: it moves as a whole
    CHECK((a.v_W_B - b.v_W_B).norm() < 3e-3);
    CHECK((b.p_W_B - before).norm() > 0.05);  // it has flown on
    const auto sigma = [](const Flight& f, int first) {
        return std::sqrt(f.covariance.diagonal().segment<3>(first).maxCoeff());
    };
    CHECK(sigma(held, kBiasAccel) == Approx(sigma(loose, kBiasAccel)).epsilon(0.05));
    for (int k = 0; k < 25; ++k) {  // the keyframe it was held by is gone by then
        held.fly(0.2);
    }
    CHECK(held.place_sigma_m() < 0.05);
}

TEST_CASE("the ends of a long interval do not share what is not known of their places", "[window]") {
    Flight flight;
    for (int k = 0; k < 5; ++k) {
        flight.fly(0.2);
    }
    flight.fly(Window::kLongInterval_s + 0.5);
    CHECK(flight.window->hold_place() == Status::kNotFound);
    for (int k = 0; k < 12; ++k) {
        flight.fly(0.2);
    }
    CHECK(ok(flight.window->hold_place()));
}
