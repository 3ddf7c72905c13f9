// SPDX-License-Identifier: BSD-2-Clause
// What is taken from the window after a keyframe's turn: its view, covariances, corrections of the cameras.
#include <cmath>

#include "estimator/flight/flight.h"
#include "estimator/flight/keyframe_snapshot.h"
#include "estimator/values/stage_scope.h"

namespace facet {
namespace {

// An inertial factor is integrated anew when its bias has moved this far: then the first-order correction errs.
constexpr double kReintegrateGyro = 2e-3;   // rad/s
constexpr double kReintegrateAccel = 5e-2;  // m/s^2
constexpr double kReintegrateScale = 1e-3;
// The front-end's order of the corrections is that of the calibration's tangent.
static_assert(CameraCorrections::kDim == kCameraTermsDim && kLeftLens == kRigDim &&
              kRightTheta == kLeftLens + kLensDim && kRightLens == kRightTheta + kPoseDim);

}  // namespace

void FlightEstimator::complete_view() {
    {
        const StageScope scope(observer_, Stage::kTracking);
        frontend_.match_surface(tracks_);
    }
    if (!s_.keyframe.view_is_open) {
        return;
    }
    fill_view(tracks_);
}

void FlightEstimator::fill_view(const FrontendOutput& seen) {
    close_view();
    const StageScope scope(observer_, Stage::kLandmarks);
    fill_keyframe_view(window_, seen, view_);
    Gauge place = gauge_of(s_.newest);
    place.covariance += s_.gauge.drift().about(place.origin_W).covariance;
    view_.heading_and_place = place.covariance;
    view_.cameras.covariance = s_.corrections.covariance;
    view_.is_exchanged = cameras_.is_exchanged();
}

void FlightEstimator::close_view() {
    if (s_.keyframe.view_is_open) {
        update_corrections();
        s_.keyframe.view_is_open = false;
    }
}

void FlightEstimator::update_covariance() {
    const StageScope scope(observer_, Stage::kSolve);
    if (ok(window_.newest_covariance(s_.now.covariance))) {
        for (int i = 0; i < kRigDim; ++i) {
            s_.calibration_sigma(i) = window_.calibration_sigma(i);
        }
    }
}

void FlightEstimator::learn_vibration() {
    const bool is_raised = s_.span.gyro_noise_ratio > 1.0 || s_.span.accel_noise_ratio > 1.0;
    const bool is_sound =
        !s_.span.has_gap && !s_.span.is_replaced && s_.span.clipped == 0 && !window_.newest().rests_since_previous;
    InertialInnovation innovation;
    if (!is_raised || !is_sound || !ok(window_.newest_innovation(innovation))) {
        return;
    }
    if (s_.span.gyro_noise_ratio > 1.0) {
        vibration_.learn_gyro(innovation);
    }
    if (s_.span.accel_noise_ratio > 1.0) {
        vibration_.learn_accel(innovation);
    }
    imu_.believe(vibration_.share());
}

void FlightEstimator::forget_corrections() {
    s_.corrections = {};
    if (config_.calibration.estimate_cameras) {
        for (int i = 0; i < CameraCorrections::kDim; ++i) {
            s_.corrections.covariance(i, i) = std::pow(config_.calibration.sigma(kRigDim + i), 2);
        }
        frontend_.correct_cameras(s_.corrections);
    }
}

void FlightEstimator::update_corrections() {
    if (!config_.calibration.estimate_cameras) {
        return;
    }
    const StageScope scope(observer_, Stage::kSolve);
    s_.corrections.right = window_.calibration().right;
    s_.corrections.lens = window_.calibration().lens;
    if (window_.has_factor()) {
        s_.corrections.covariance = window_.cameras_covariance();
    }
    frontend_.correct_cameras(s_.corrections);
}

void FlightEstimator::reintegrate() {
    const StageScope scope(observer_, Stage::kPropagation);
    const auto& keyframes = window_.state().keyframes;
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        if (!keyframes[k].has_imu_factor) {
            continue;
        }
        const ImuBias& bias = keyframes[k - 1].state.bias;
        const Preintegration& before = keyframes[k].imu_from_previous.preintegration();
        const ImuBias& then = before.bias();
        const bool moved = (bias.gyro - then.gyro).norm() > kReintegrateGyro ||
                           (bias.accel - then.accel).norm() > kReintegrateAccel ||
                           before.scale().box_minus_to(window_.calibration().imu).norm() > kReintegrateScale;
        Preintegration anew = preintegration_from(bias);
        if (moved && ok(imu_.integrate_between(keyframes[k - 1].stamp, keyframes[k].stamp, config_.imu_noise, anew))) {
            // It is refused only where the old factor would have been refused too, and that one was accepted.
            static_cast<void>(window_.replace_imu_factor(static_cast<int>(k), anew));
        }
    }
}

}  // namespace facet
