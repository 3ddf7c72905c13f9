// SPDX-License-Identifier: BSD-2-Clause
// What the estimator does with a frame that becomes a keyframe, and what it takes from the window afterwards.
#include <algorithm>
#include <cmath>

#include "estimator/api/estimator_impl.h"
#include "estimator/api/keyframe_snapshot.h"
#include "estimator/window/stage_scope.h"

namespace facet {
namespace {

// An inertial factor is integrated anew when its bias has moved this far: then the first-order correction errs.
constexpr double kReintegrateGyro = 2e-3;   // rad/s
constexpr double kReintegrateAccel = 5e-2;  // m/s^2
constexpr double kReintegrateScale = 1e-3;
// Before the first estimate is reported the window may take more steps: its guess may be far off, and it is small. So
// may it while readings are in doubt: a hard turn leads far from the steady motion that stands in for them.
constexpr double kFarEffort = 6.0;
// After a frame that came too late, up to the next keyframe: share of the solver's steps.
constexpr double kLateEffort = 0.5;
// The front-end's order of the corrections is that of the calibration's tangent.
static_assert(CameraCorrections::kDim == kCameraTermsDim && kLeftLens == kRigDim &&
              kRightTheta == kLeftLens + kLensDim && kRightLens == kRightTheta + kPoseDim);

}  // namespace

KeyframeInput Estimator::Impl::keyframe_input() const {
    KeyframeInput input;
    input.stamp = now.stamp;
    input.observations = {tracks.observations.data(), tracks.observations.size()};
    input.rests_since_previous = rests && tracks.is_still;
    input.images_rest = tracks.is_still;
    ImuSample sample;
    if (ok(imu.interpolate(now.stamp, sample))) {
        input.w_B = sample.w_B - now.state.bias.gyro;
    }
    return input;
}

double Estimator::Impl::effort() const {
    const bool may_be_far = monitor.state() == TrackingState::kInit || doubt.is_active();
    return may_be_far ? kFarEffort : (is_late ? kLateEffort : 1.0);
}

bool Estimator::Impl::enter_window(const KeyframeInput& input, const Preintegration& preintegration, double effort) {
    if (!ok(window.add_keyframe(input, preintegration))) {
        return false;
    }
    summary = window.optimize(effort);
    summary_is_new = true;
    frontend.drop_tracks(window.rejected());
    now.state = window.newest().state;
    follow_doubt();
    judge_bend();
    reintegrate();
    update_covariance();
    learn_vibration();
    now.imu_scale = window.calibration().imu;
    now.vibration = vibration.share();
    newest = now;
    static_cast<void>(window.fill_map(map));  // on failure it is empty: frames are predicted then
    view_is_open = true;
    return true;
}

void Estimator::Impl::take_keyframe(const Preintegration& preintegration, const NavState* guess) {
    KeyframeInput input = keyframe_input();
    input.guess = guess;
    const Eigen::Vector3d predicted_W = now.state.p_W_B;
    if (!enter_window(input, preintegration, effort())) {
        return;
    }
    const bool is_lost = monitor.state() == TrackingState::kLost;
    leap_W = is_lost ? (leap_W + now.state.p_W_B - predicted_W).eval() : Eigen::Vector3d::Zero();
    rests = true;
    hastened = std::max(0, hastened - 1);
    if (monitor.state() == TrackingState::kInit) {
        complete_view();  // while the window is as it was optimized
        motion_start.add_keyframe(now.stamp, input.observations, imu);
        monocular_start.add_keyframe(now.stamp, input.observations, imu, now.state.bias);
        if (may_stand) {
            begin_shaken_rest();
        } else {
            second_opinion();
        }
    }
}

void Estimator::Impl::complete_view() {
    {
        const StageScope scope(observer, Stage::kTracking);
        frontend.match_surface(tracks);
    }
    if (!view_is_open) {
        return;
    }
    fill_view(tracks);
}

void Estimator::Impl::fill_view(const FrontendOutput& seen) {
    close_view();
    const StageScope scope(observer, Stage::kLandmarks);
    fill_keyframe_view(window, seen, view);
    Gauge place = gauge_of(newest);
    place.covariance += drift.about(place.origin_W).covariance;
    view.heading_and_place = place.covariance;
    view.cameras.covariance = corrections.covariance;
    view.is_exchanged = is_exchanged;
}

void Estimator::Impl::close_view() {
    if (view_is_open) {
        update_corrections();
        view_is_open = false;
    }
}

void Estimator::Impl::update_covariance() {
    const StageScope scope(observer, Stage::kSolve);
    if (ok(window.newest_covariance(now.covariance))) {
        for (int i = 0; i < kRigDim; ++i) {
            calibration_sigma(i) = window.calibration_sigma(i);
        }
    }
}

void Estimator::Impl::learn_vibration() {
    const bool is_raised = span.gyro_noise_ratio > 1.0 || span.accel_noise_ratio > 1.0;
    const bool is_sound =
        !span.has_gap && !span.is_doubted && span.clipped == 0 && !window.newest().rests_since_previous;
    InertialInnovation innovation;
    if (!is_raised || !is_sound || !ok(window.newest_innovation(innovation))) {
        return;
    }
    if (span.gyro_noise_ratio > 1.0) {
        vibration.learn_gyro(innovation);
    }
    if (span.accel_noise_ratio > 1.0) {
        vibration.learn_accel(innovation);
    }
    imu.believe(vibration.share());
}

void Estimator::Impl::forget_corrections() {
    corrections = {};
    if (config.calibration.estimate_cameras) {
        for (int i = 0; i < CameraCorrections::kDim; ++i) {
            corrections.covariance(i, i) = std::pow(config.calibration.sigma(kRigDim + i), 2);
        }
        frontend.correct_cameras(corrections);
    }
}

void Estimator::Impl::update_corrections() {
    if (!config.calibration.estimate_cameras) {
        return;
    }
    const StageScope scope(observer, Stage::kSolve);
    corrections.right = window.calibration().right;
    corrections.lens = window.calibration().lens;
    if (window.has_factor()) {
        corrections.covariance = window.cameras_covariance();
    }
    frontend.correct_cameras(corrections);
}

void Estimator::Impl::reintegrate() {
    const StageScope scope(observer, Stage::kPropagation);
    const auto& keyframes = window.state().keyframes;
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        if (!keyframes[k].has_imu_factor) {
            continue;
        }
        const ImuBias& bias = keyframes[k - 1].state.bias;
        const Preintegration& before = keyframes[k].imu_from_previous.preintegration();
        const ImuBias& then = before.bias();
        const bool moved = (bias.gyro - then.gyro).norm() > kReintegrateGyro ||
                           (bias.accel - then.accel).norm() > kReintegrateAccel ||
                           before.scale().box_minus_to(window.calibration().imu).norm() > kReintegrateScale;
        Preintegration anew = preintegration_from(bias);
        if (moved && ok(imu.integrate_between(keyframes[k - 1].stamp, keyframes[k].stamp, config.imu_noise, anew))) {
            // It is refused only where the old factor would have been refused too, and that one was accepted.
            static_cast<void>(window.replace_imu_factor(static_cast<int>(k), anew));
        }
    }
}

}  // namespace facet
