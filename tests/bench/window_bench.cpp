// SPDX-License-Identifier: BSD-2-Clause
// Times of the smoother's parts. Budget on one core: a keyframe with ten planes and 300 landmarks on them takes at most
// one and a half times what it takes without planes.
#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "estimator/window/window.h"
#include "tests/support/synthetic_flight.h"

namespace {

using namespace facet;
using test::SyntheticFlight;

constexpr double kStep_s = 0.2;
constexpr int kFilled = 25;  // keyframes after which the window is full and planes have come in
constexpr int kTimed = 25;   // keyframes measured before the flight begins anew

SyntheticFlight::Options noisy_room() {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = 0.5;
    options.bias.gyro = {0.005, -0.008, 0.006};
    options.landmarks = 1200;
    options.in_room = true;
    return options;
}

/// The room's sides, every one as several planes that share its landmarks.
PlaneProposals divided(const PlaneProposals& sides, int pieces) {
    PlaneProposals planes;
    for (const PlaneProposal& side : sides) {
        for (int piece = 0; piece < pieces && !planes.full(); ++piece) {
            PlaneProposal plane = side;
            plane.id = {static_cast<std::uint32_t>(planes.size())};
            plane.landmarks.clear();
            for (std::size_t i = static_cast<std::size_t>(piece); i < side.landmarks.size();
                 i += static_cast<std::size_t>(pieces)) {
                plane.landmarks.push_back(side.landmarks[i]);
            }
            planes.push_back(plane);
        }
    }
    return planes;
}

/// A flight in a room, prepared before it is timed.
class RoomFlight {
public:
    explicit RoomFlight(int keyframes) : flight_(noisy_room()) {
        config_.keyframes = keyframes;
        config_.pixel_sigma_px = 0.5;
        const ImuBias bias = flight_.state(0.0).bias;
        for (int k = 0; k < kFilled + kTimed; ++k) {
            observations_.push_back(flight_.observe(kStep_s * k, 300));
            preintegrations_.push_back(
                flight_.preintegrate(kStep_s * (k - 1), kStep_s * k, bias, test::euroc_like_noise()));
        }
    }

    /// Begins anew and flies until the window is full.
    bool begin(RegularityMode mode, const PlaneProposals& planes) {
        RegularityConfig regularity;
        regularity.mode = mode;
        window_->configure(config_, {}, flight_.rig(), test::euroc_like_noise(), regularity);
        const Eigen::Matrix<double, kStateDim, kStateDim> information =
            test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
        window_->start({test::at(0.0), Eigen::Vector3d::Zero(), false, observations_.front()}, flight_.state(0.0),
                       information);
        window_->set_planes(planes);
        next_ = 1;
        while (next_ < kFilled) {
            if (!step()) {
                return false;
            }
        }
        return true;
    }

    bool is_over() const { return next_ == observations_.size(); }
    bool step() {
        const std::size_t k = next_++;
        const double t = kStep_s * static_cast<double>(k);
        const KeyframeInput input{test::at(t), Eigen::Vector3d::Zero(), false, observations_[k]};
        const bool is_added = ok(window_->add_keyframe(input, preintegrations_[k]));
        summary_ = window_->optimize();
        return is_added && !summary_.solver.solver_failed;
    }
    const WindowSummary& summary() const { return summary_; }
    Window& window() { return *window_; }
    PlaneProposals planes() const { return flight_.planes(); }

private:
    WindowConfig config_;
    SyntheticFlight flight_;
    std::vector<std::vector<FeatureObservation>> observations_;
    std::vector<Preintegration> preintegrations_;
    std::unique_ptr<Window> window_ = std::make_unique<Window>();
    WindowSummary summary_;  ///< of the newest step
    std::size_t next_ = 0;
};

/// One keyframe: make room for it, add it, optimize. Arguments: keyframes in the window, planes per side of the room
/// (0: mode s).
void window_keyframe(benchmark::State& state) {
    RoomFlight flight(static_cast<int>(state.range(0)));
    const int pieces = static_cast<int>(state.range(1));
    const RegularityMode mode = pieces == 0 ? RegularityMode::kS : RegularityMode::kSpr;
    const PlaneProposals planes = divided(flight.planes(), pieces);
    bool fine = flight.begin(mode, planes);
    for (auto _ : state) {
        if (flight.is_over()) {
            state.PauseTiming();
            fine = flight.begin(mode, planes) && fine;
            state.ResumeTiming();
        }
        fine = flight.step() && fine;
    }
    if (!fine) {
        state.SkipWithError("a step failed");
    }
    int constraints = 0;
    for (const WindowPlane& plane : flight.window().state().planes) {
        constraints += plane.constraints;
    }
    state.counters["planes"] = static_cast<double>(flight.window().state().planes.size());
    state.counters["constraints"] = constraints;
    state.counters["landmarks"] = flight.summary().fit.active_landmarks;
}
BENCHMARK(window_keyframe)
    ->ArgNames({"keyframes", "planes_a_side"})
    ->Args({10, 0})
    ->Args({20, 0})
    ->Args({20, 1})
    ->Args({20, 2})
    ->Args({20, 3})
    ->Args({30, 0})
    ->Unit(benchmark::kMillisecond);

/// Marginal covariance of the newest keyframe from the factor that optimize() left.
void newest_covariance(benchmark::State& state) {
    RoomFlight flight(20);
    if (!flight.begin(RegularityMode::kS, {})) {
        state.SkipWithError("a step failed");
    }
    Eigen::Matrix<double, kStateDim, kStateDim> covariance;
    for (auto _ : state) {
        benchmark::DoNotOptimize(flight.window().newest_covariance(covariance));
        benchmark::DoNotOptimize(covariance);
    }
}
BENCHMARK(newest_covariance)->Unit(benchmark::kMicrosecond);

/// One inertial sample into a preintegration with covariance and bias Jacobians.
void preintegrate_sample(benchmark::State& state) {
    const ImuNoise noise = test::euroc_like_noise();
    ImuSample sample{test::at(0.0), {0.1, -0.2, 0.3}, {0.4, -0.3, 9.7}};
    Preintegration preintegration{ImuBias{}};
    for (auto _ : state) {
        ImuSample next = sample;
        next.stamp = sample.stamp + Duration::from_seconds(0.005);
        benchmark::DoNotOptimize(preintegration.integrate(sample, next, noise));
        sample = next;
    }
}
BENCHMARK(preintegrate_sample)->Unit(benchmark::kNanosecond);

}  // namespace
