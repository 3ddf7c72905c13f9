// SPDX-License-Identifier: BSD-2-Clause
// The snapshot of landmarks that the mesh reads, on a synthetic flight whose landmarks are known.
#include "estimator/flight/keyframe_snapshot.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>

#include "estimator/window/window.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/synthetic_flight.h"

namespace facet::keyframe_snapshot_test {

using facet::test::SyntheticFlight;

namespace {

constexpr double kStep_s = 0.2;
constexpr int kKeyframes = 8;

/// A window at the end of a flight, and what its newest keyframe saw.
struct Flown {
    explicit Flown(const SyntheticFlight::Options& options) : flight(options) {
        const ImuNoise noise = test::euroc_like_noise();
        WindowConfig config;
        config.keyframes = kKeyframes;
        config.pixel_sigma_px = std::max(options.pixel_sigma, 0.5);
        config.learn_pixel_sigma = false;
        window->configure(config, {}, flight.rig(), noise);
        NavState start = flight.state(0.0);
        start.bias = {};
        const auto first = flight.observe(0.0);
        const Eigen::Matrix<double, kStateDim, kStateDim> information =
            1e6 * Eigen::Matrix<double, kStateDim, kStateDim>::Identity();
        window->start({test::at(0.0), Eigen::Vector3d::Zero(), false, {first.data(), first.size()}}, start,
                      information);
        for (int k = 1; k < kKeyframes; ++k) {
            const double t = k * kStep_s;
            const Preintegration p = flight.preintegrate(t - kStep_s, t, window->newest().state.bias, noise);
            tracks->observations.clear();
            for (const FeatureObservation& o : flight.observe(t)) {
                // Every third track is lost half way; of every fifth one the newest keyframe is the first view.
                if ((k < kKeyframes / 2 || o.landmark.value % 3 != 0) &&
                    (k == kKeyframes - 1 || o.landmark.value % 5 != 0)) {
                    tracks->observations.push_back(o);
                }
            }
            REQUIRE(ok(window->add_keyframe(
                {test::at(t), flight.rate(t), false, {tracks->observations.data(), tracks->observations.size()}}, p)));
            window->optimize();
        }
    }
    SyntheticFlight flight;
    std::unique_ptr<Window> window = std::make_unique<Window>();
    std::unique_ptr<FrontendOutput> tracks = std::make_unique<FrontendOutput>();
    std::unique_ptr<KeyframeView> view = std::make_unique<KeyframeView>();
};

}  // namespace

TEST_CASE("a snapshot has of every landmark where it is, who saw it and when", "[landmarks]") {
    Flown flown({});
    const test::AllocationGuard guard;
    fill_keyframe_view(*flown.window, *flown.tracks, *flown.view);
    CHECK(guard.allocations() == 0);
    const KeyframeView& view = *flown.view;
    const WindowState& state = flown.window->state();
    CHECK(view.number == 1);
    CHECK(view.stamp == test::at((kKeyframes - 1) * kStep_s));
    CHECK(view.oldest_stamp == state.keyframes.front().stamp);
    const Se3 T_W_B{flown.window->newest().state.q_W_B, flown.window->newest().state.p_W_B};
    const Se3 T_W_C0 = T_W_B * flown.flight.rig().T_B_C0;
    CHECK((view.T_W_C0.p - T_W_C0.p).norm() < 1e-6);
    CHECK(view.T_W_C0.q.angularDistance(T_W_C0.q) < 1e-6);
    REQUIRE(view.landmarks.size() > 60);
    CHECK(std::is_sorted(view.landmarks.begin(), view.landmarks.end(),
                         [](const LandmarkSnapshot& a, const LandmarkSnapshot& b) { return a.id < b.id; }));
    int tracked = 0;
    int lost = 0;
    int seen_once = 0;
    for (const LandmarkSnapshot& s : view.landmarks) {
        INFO("landmark " << s.id.value);
        const Eigen::Vector3d truth = flown.flight.landmarks()[s.id.value];
        REQUIRE((s.p_W - truth).norm() < 0.01 * (truth - view.T_W_C0.p).norm());
        const Eigen::Vector3d p_C = view.T_W_C0.inverse() * s.p_W;
        REQUIRE(s.depth_m == Approx(p_C.z()).epsilon(1e-4).margin(1e-4));
        const Landmark* landmark = nullptr;
        for (int i = 0; i < state.landmarks.size(); ++i) {
            landmark = state.landmarks[i].id == s.id ? &state.landmarks[i] : landmark;
        }
        REQUIRE(landmark != nullptr);
        const auto& sightings = landmark->observations;
        REQUIRE(s.keyframes == static_cast<int>(sightings.size()));
        REQUIRE(s.stereo == std::count_if(sightings.begin(), sightings.end(),
                                          [](const LandmarkObservation& o) { return o.measurement.has_right; }));
        REQUIRE(s.first_stamp == state.keyframes[static_cast<std::size_t>(sightings.front().keyframe)].stamp);
        REQUIRE(s.unseen_keyframes == static_cast<int>(state.keyframes.size()) - 1 - sightings.back().keyframe);
        REQUIRE(s.is_tracked == (s.unseen_keyframes == 0));
        REQUIRE_FALSE(s.plane.valid());
        if (s.is_tracked) {
            const auto seen = std::find_if(flown.tracks->observations.begin(), flown.tracks->observations.end(),
                                           [&](const FeatureObservation& o) { return o.landmark == s.id; });
            REQUIRE(seen != flown.tracks->observations.end());
            REQUIRE(s.left_xy == seen->left_xy);
            REQUIRE(s.left_px == seen->left_px);
            ++tracked;
        } else {
            ++lost;
        }
        seen_once += s.keyframes == 1 ? 1 : 0;
    }
    CHECK(tracked > 30);
    CHECK(lost > 10);
    CHECK(seen_once > 5);  // triangulated from their stereo match alone
    fill_keyframe_view(*flown.window, *flown.tracks, *flown.view);
    CHECK(view.number == 2);
}

TEST_CASE("surface points come with the keyframe that saw them and with honest covariances", "[landmarks]") {
    SyntheticFlight::Options options;
    options.pixel_sigma = 0.5;
    double chi2 = 0.0;
    int count = 0;
    for (unsigned seed = 1; seed <= 6; ++seed) {
        options.seed = seed;
        Flown flown(options);
        // The newest keyframe's observations once more, as points that the window does not know.
        constexpr std::uint32_t kFirst = 100000;
        for (const FeatureObservation& o : flown.flight.observe((kKeyframes - 1) * kStep_s)) {
            if (o.has_right) {
                flown.tracks->surface.push_back(o);
                flown.tracks->surface.back().landmark.value = kFirst + o.landmark.value;
            }
        }
        const test::AllocationGuard guard;
        fill_keyframe_view(*flown.window, *flown.tracks, *flown.view);
        CHECK(guard.allocations() == 0);
        const KeyframeView& view = *flown.view;
        const WindowState& state = flown.window->state();
        REQUIRE(view.keyframes.size() == state.keyframes.size());
        for (std::size_t k = 0; k < view.keyframes.size(); ++k) {
            const Keyframe& keyframe = state.keyframes[k];
            REQUIRE(view.keyframes[k].stamp == keyframe.stamp);
            const Se3 T_W_C0 = Se3{keyframe.state.q_W_B, keyframe.state.p_W_B} * flown.flight.rig().T_B_C0;
            // But for the estimated time offset.
            REQUIRE((view.keyframes[k].T_W_C0.p - T_W_C0.p).norm() < 2e-3);
            REQUIRE(view.keyframes[k].T_W_C0.q.angularDistance(T_W_C0.q) < 1e-3);
        }
        REQUIRE(view.keyframes.back().T_W_C0.p == view.T_W_C0.p);
        REQUIRE(view.surface.size() > 20);
        for (const LandmarkSnapshot& s : view.surface) {
            REQUIRE(s.id.value >= kFirst);
            REQUIRE(s.is_tracked);
            REQUIRE(s.keyframes == 1);
            REQUIRE(s.first_stamp == view.stamp);
            REQUIRE((view.landmarks.empty() || view.landmarks.back().id < s.id));
            const Eigen::Vector3d error = s.p_W - flown.flight.landmarks()[s.id.value - kFirst];
            chi2 += error.dot(s.covariance_W.cast<double>().inverse() * error);
            ++count;
        }
    }
    CHECK(chi2 / (3.0 * count) == Approx(1.0).epsilon(0.35));  // the pose's own error is left out
}

TEST_CASE("the covariance of a snapshot says how far the landmark is off", "[landmarks]") {
    SyntheticFlight::Options options;
    options.pixel_sigma = 1.0;
    double chi2_position = 0.0;
    double chi2_residual = 0.0;
    double depth_ratio2 = 0.0;
    int count = 0;
    for (unsigned seed = 1; seed <= 12; ++seed) {
        options.seed = seed;
        Flown flown(options);
        fill_keyframe_view(*flown.window, *flown.tracks, *flown.view);
        for (const LandmarkSnapshot& s : flown.view->landmarks) {
            const Eigen::Matrix3d covariance = s.covariance_W.cast<double>();
            REQUIRE(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues().minCoeff() > 0.0);
            const Eigen::Vector3d ray = (s.p_W - flown.view->T_W_C0.p).normalized();
            REQUIRE(s.depth_sigma_m == Approx(std::sqrt(ray.dot(covariance * ray))).epsilon(1e-3));
            if (s.keyframes < 3) {
                continue;
            }
            const Eigen::Vector3d error = s.p_W - flown.flight.landmarks()[s.id.value];
            chi2_position += error.dot(covariance.inverse() * error);
            depth_ratio2 += std::pow(ray.dot(error) / static_cast<double>(s.depth_sigma_m), 2);
            chi2_residual += static_cast<double>(s.chi2);
            ++count;
        }
    }
    REQUIRE(count > 150);
    CHECK(chi2_residual / count == Approx(1.0).margin(0.35));
    // Given the poses the mean would be 3 and 1; the poses' own errors, left out on purpose, add to it.
    CHECK(chi2_position / count > 2.0);
    CHECK(chi2_position / count < 9.0);
    CHECK(depth_ratio2 / count > 0.6);
    CHECK(depth_ratio2 / count < 3.0);
}

}  // namespace facet::keyframe_snapshot_test
