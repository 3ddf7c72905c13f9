// SPDX-License-Identifier: BSD-2-Clause
// The smoother, fed with observations that no camera makes: not numbers, behind the camera, a billion pixels away.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "estimator/window/window.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/support/synthetic_flight.h"

using namespace facet;
using facet::test::FuzzInput;
using facet::test::SyntheticFlight;

namespace {

constexpr double kStep_s = 0.1;
constexpr int kKeyframes = 5;  // full after half of the flight: all that keyframes go through happens
constexpr int kFeatures = 16;
constexpr int kSteps = 10;

double strange(FuzzInput& input, double good) {
    switch (input.take<std::uint8_t>() % 8) {
        case 0: return std::numeric_limits<double>::quiet_NaN();
        case 1: return std::numeric_limits<double>::infinity();
        case 2: return 1e9;
        case 3: return -good;
        case 4: return input.take<double>();
        case 5: return good + input.take<std::int8_t>() / 64.0;
        default: return good;
    }
}

/// A byte a track chooses what is wrong with it.
void spoil(FuzzInput& input, std::vector<FeatureObservation>& seen) {
    for (FeatureObservation& o : seen) {
        const auto what = input.take<std::uint8_t>();
        if ((what & 1U) != 0) {
            o.left_xy.x() = strange(input, o.left_xy.x());
            o.left_px.x() = static_cast<float>(strange(input, o.left_px.x()));
        }
        if ((what & 2U) != 0) {
            o.right_xy = {strange(input, o.right_xy.x()), strange(input, o.right_xy.y())};
        }
        if ((what & 4U) != 0) {  // no parallax
            o.right_xy = o.left_xy;
            o.right_px = o.left_px;
        }
        if ((what & 8U) != 0) {
            o.has_right = !o.has_right;
        }
    }
}

/// What the vehicle would see and feel, computed once: it was most of the work of an input.
struct Recorded {
    Recorded() {
        SyntheticFlight::Options options;
        options.landmarks = 40;
        SyntheticFlight flight(options);
        rig = flight.rig();
        for (int k = 0; k <= kSteps; ++k) {
            const double t = kStep_s * k;
            seen.push_back(flight.observe(t, kFeatures));
            rates.push_back(flight.rate(t));
            felt.push_back(flight.preintegrate(std::max(0.0, t - kStep_s), std::max(kStep_s, t), {}, noise));
        }
        begin = flight.state(0.0);
    }

    ImuNoise noise = test::euroc_like_noise();
    StereoRig rig;
    NavState begin;
    std::vector<std::vector<FeatureObservation>> seen;
    std::vector<Eigen::Vector3d> rates;
    std::vector<Preintegration> felt;  ///< since the keyframe before
};

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    FuzzInput input(data, size);
    static const Recorded flight;
    WindowConfig config;
    config.keyframes = kKeyframes;
    static const auto window = std::make_unique<Window>();
    window->configure(config, {}, flight.rig, flight.noise);
    const Eigen::Matrix<double, kStateDim, kStateDim> information =
        test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
    auto seen = flight.seen[0];
    spoil(input, seen);
    window->start({test::at(0.0), Eigen::Vector3d::Zero(), false, {seen.data(), seen.size()}}, flight.begin,
                  information);
    for (std::size_t k = 1; k <= kSteps && !input.empty(); ++k) {
        const double t = kStep_s * static_cast<double>(k);
        seen = flight.seen[k];
        spoil(input, seen);
        static_cast<void>(
            window->add_keyframe({test::at(t), flight.rates[k], false, {seen.data(), seen.size()}}, flight.felt[k]));
        static_cast<void>(window->optimize());
        const NavState& state = window->newest().state;
        test::require(state.q_W_B.coeffs().allFinite() && state.p_W_B.allFinite() && state.v_W_B.allFinite());
        Eigen::Matrix<double, kStateDim, kStateDim> covariance;
        if (ok(window->newest_covariance(covariance))) {
            test::require(covariance.allFinite() && covariance.diagonal().minCoeff() > 0.0);
        }
    }
    return 0;
}
