// SPDX-License-Identifier: BSD-2-Clause
// How well the first place is known must not matter to the rest: no measurement of the window has a say in it.
#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "estimator/window/window.h"
#include "tests/support/synthetic_flight.h"

namespace facet::loose_place_test {

using facet::test::SyntheticFlight;

namespace {

using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;

constexpr double kStep_s = 0.2;

struct Path {
    std::vector<Eigen::Vector3d> places;  ///< of the newest keyframe
    double place_sigma_m = 0.0;           ///< of the last one
};

/// @param sigma_m  of the first place, which is the true one
Path fly(const SyntheticFlight::Options& options, double sigma_m, double duration_s) {
    SyntheticFlight flight(options);
    const ImuNoise noise = test::euroc_like_noise();
    WindowConfig config;
    config.keyframes = 10;
    config.pixel_sigma_px = 0.5;
    const auto window = std::make_unique<Window>();
    window->configure(config, {}, flight.rig(), noise);
    Eigen::Matrix<double, kStateDim, 1> sigmas = test::start_sigmas();
    sigmas.segment<3>(kPos).setConstant(sigma_m);
    const auto first = flight.observe(0.0);
    window->start({test::at(0.0), flight.rate(0.0), false, {first.data(), first.size()}}, flight.state(0.0),
                  StateMatrix(sigmas.cwiseAbs2().cwiseInverse().asDiagonal()));
    Path path;
    for (double t = kStep_s; t <= duration_s + 1e-9; t += kStep_s) {
        const Preintegration p = flight.preintegrate(t - kStep_s, t, window->newest().state.bias, noise);
        const auto seen = flight.observe(t);
        REQUIRE(ok(window->add_keyframe({test::at(t), flight.rate(t), false, {seen.data(), seen.size()}}, p)));
        REQUIRE_FALSE(window->optimize().solver.solver_failed);
        path.places.push_back(window->newest().state.p_W_B);
    }
    StateMatrix covariance;
    REQUIRE(ok(window->newest_covariance(covariance)));
    path.place_sigma_m = std::sqrt(covariance.diagonal().segment<3>(kPos).maxCoeff());
    return path;
}

double largest_distance(const Path& a, const Path& b) {
    double largest = 0.0;
    for (std::size_t i = 0; i < a.places.size(); ++i) {
        largest = std::max(largest, (a.places[i] - b.places[i]).norm());
    }
    return largest;
}

}  // namespace

TEST_CASE("a window does not move for how badly it knows its first place", "[window]") {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = 0.5;
    options.seed = GENERATE(1U, 2U);
    const Path known = fly(options, 1e-4, 20.0);
    for (const double sigma_m : {0.05, 0.2, 1.0}) {
        CAPTURE(sigma_m);
        const Path loose = fly(options, sigma_m, 20.0);
        CHECK(largest_distance(known, loose) < 1e-3);
        CHECK(loose.place_sigma_m > 0.9 * sigma_m);  // and does not come to believe in it
    }
}

TEST_CASE("exact data keep a window that hardly knows its place on the true path", "[window]") {
    // GIVEN exact data and a first place known to 20 cm
    const Path path = fly({}, 0.2, 20.0);
    // THEN the window stays on the true path
    SyntheticFlight flight({});
    double t = kStep_s;
    for (const Eigen::Vector3d& p_W : path.places) {
        CHECK((p_W - flight.state(t).p_W_B).norm() < 1e-3);
        t += kStep_s;
    }
}

}  // namespace facet::loose_place_test
