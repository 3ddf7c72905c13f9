// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/estimator.h"

#include <cmath>

#include "estimator/frontend/frontend.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/static_init.h"
#include "estimator/window/stage_scope.h"
#include "estimator/window/window.h"

namespace facet {
namespace {

// A start in motion is over when the newest state is known this well.
constexpr double kReadyVelocitySigma = 0.10;  // m/s
constexpr double kReadyTiltSigma = 0.05;      // rad
// Below this many tracked features vision does not hold the pose.
constexpr int kFewFeatures = 12;
constexpr int kFewStereo = 8;
constexpr double kLostAfter = 2.0;       // s without enough features
constexpr double kMaxGyroBias = 0.5;     // rad/s
constexpr double kMaxAccelBias = 2.0;    // m/s^2
constexpr double kHighVisionChi2 = 4.0;  // per degree of freedom
// An inertial factor is integrated anew when its bias has moved this far: then the first-order correction errs.
constexpr double kReintegrateGyro = 2e-3;   // rad/s
constexpr double kReintegrateAccel = 5e-2;  // m/s^2

}  // namespace

struct Estimator::Impl {
    EstimatorConfig config;
    StereoRig rig;
    StageObserver* observer = nullptr;
    ImuBuffer imu;
    Frontend frontend;
    FrontendOutput tracks;
    Window window;
    bool has_frame = false;  ///< a frame has been taken in
    bool is_ready = false;   ///< the state is good enough to be given out
    Timestamp last_image;    ///< stamp of the last frame as given
    Timestamp last_frame;    ///< likewise, in the IMU's clock
    Timestamp last_vision;   ///< last frame with enough features
    double time_offset_sigma_s = 0.0;
    WindowSummary summary;

    void reset();
    /// Stamp of an image in the IMU's clock.
    Timestamp imu_stamp(Timestamp image) const {
        return image + Duration::from_seconds(window.calibration().time_offset_s);
    }
    KeyframeInput keyframe_input(Timestamp stamp, const ImuBias& bias) const;
    Status start(const StereoFrame& frame, Estimate& estimate);
    Status track(const StereoFrame& frame, Timestamp stamp, const Eigen::Vector3d& gyro_bias);
    Status predict(Timestamp stamp, Preintegration& preintegration, bool& has_gap) const;
    void take_keyframe(Timestamp stamp, const Preintegration& preintegration);
    void reintegrate();
    void judge_readiness();
    void fill_health(const StereoFrame& frame, bool image_ok, bool has_gap, Health& health) const;
};

void Estimator::Impl::reset() {
    imu.clear(config.imu_noise.rate_hz);
    frontend.reset();
    window.configure(config.window, config.calibration, rig, config.imu_noise);
    has_frame = false;
    is_ready = false;
    summary = {};
}

KeyframeInput Estimator::Impl::keyframe_input(Timestamp stamp, const ImuBias& bias) const {
    KeyframeInput input;
    input.stamp = stamp;
    input.observations = {tracks.observations.data(), tracks.observations.size()};
    ImuSample sample;
    if (ok(imu.interpolate(stamp, sample))) {
        input.w_B = sample.w_B - bias.gyro;
    }
    return input;
}

Status Estimator::Impl::track(const StereoFrame& frame, Timestamp stamp, const Eigen::Vector3d& gyro_bias) {
    Eigen::Quaterniond q_Bp_B = Eigen::Quaterniond::Identity();
    if (has_frame) {
        const StageScope scope(observer, Stage::kPropagation);
        FACET_TRY(imu.rotation_between(last_frame, stamp, gyro_bias, q_Bp_B));
    }
    const StageScope scope(observer, Stage::kTracking);
    return frontend.process(frame, q_Bp_B, tracks);
}

Status Estimator::Impl::start(const StereoFrame& frame, Estimate& estimate) {
    const Timestamp stamp = imu_stamp(frame.stamp);
    estimate = {};
    estimate.stamp = stamp;
    InitialState initial;
    const Status found = initialize_state(imu, stamp, config.initializer, initial);
    if (!ok(found)) {
        return Status::kOk;  // INIT: not enough data before this frame
    }
    FACET_TRY(track(frame, stamp, initial.state.bias.gyro));
    has_frame = true;
    last_image = frame.stamp;
    last_frame = last_vision = stamp;
    if (!tracks.is_keyframe) {
        return Status::kOk;
    }
    window.start(keyframe_input(stamp, initial.state.bias), initial.state, initial.information());
    is_ready = initial.is_still;
    estimate.state = initial.state;
    fill_health(frame, true, false, estimate.health);
    return Status::kOk;
}

Status Estimator::Impl::predict(Timestamp stamp, Preintegration& preintegration, bool& has_gap) const {
    const StageScope scope(observer, Stage::kPropagation);
    preintegration.reset(window.newest().state.bias);
    ImuSpan span;
    FACET_TRY(imu.integrate_between(window.newest().stamp, stamp, config.imu_noise, preintegration, &span));
    has_gap = span.has_gap;
    return Status::kOk;
}

void Estimator::Impl::take_keyframe(Timestamp stamp, const Preintegration& preintegration) {
    if (!ok(window.add_keyframe(keyframe_input(stamp, window.newest().state.bias), preintegration))) {
        return;
    }
    summary = window.optimize();
    frontend.drop_tracks(window.rejected());
    reintegrate();
    judge_readiness();
}

/// Integrates the inertial factors anew whose bias has moved too far for their first-order correction.
void Estimator::Impl::reintegrate() {
    const StageScope scope(observer, Stage::kPropagation);
    const auto& keyframes = window.state().keyframes;
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        const ImuBias& now = keyframes[k - 1].state.bias;
        const ImuBias& then = keyframes[k].imu_from_previous.preintegration().bias();
        const bool moved =
            (now.gyro - then.gyro).norm() > kReintegrateGyro || (now.accel - then.accel).norm() > kReintegrateAccel;
        Preintegration anew(now);
        if (moved && ok(imu.integrate_between(keyframes[k - 1].stamp, keyframes[k].stamp, config.imu_noise, anew))) {
            // Refused only where the old factor was refused as well, and that one was taken.
            static_cast<void>(window.replace_imu_factor(static_cast<int>(k), anew));
        }
    }
}

void Estimator::Impl::judge_readiness() {
    Eigen::Matrix<double, kStateDim, kStateDim> covariance;
    if (!ok(window.newest_covariance(covariance))) {
        return;
    }
    time_offset_sigma_s = window.calibration_sigma(kTimeOffset);
    if (is_ready) {
        return;
    }
    const double velocity = std::sqrt(covariance.block<3, 3>(kVel, kVel).diagonal().maxCoeff());
    const Eigen::Matrix3d R_W_B = window.newest().state.q_W_B.toRotationMatrix();
    const Eigen::Matrix3d theta_W = R_W_B * covariance.block<3, 3>(kTheta, kTheta) * R_W_B.transpose();
    is_ready = velocity < kReadyVelocitySigma && std::sqrt(std::max(theta_W(0, 0), theta_W(1, 1))) < kReadyTiltSigma;
}

void Estimator::Impl::fill_health(const StereoFrame& frame, bool image_ok, bool has_gap, Health& health) const {
    health.is_keyframe = image_ok && tracks.is_keyframe;
    health.is_still = image_ok && tracks.is_still;
    health.tracked = image_ok ? tracks.tracked : 0;
    health.detected = image_ok ? tracks.detected : 0;
    health.stereo = image_ok ? tracks.stereo : 0;
    health.outliers = image_ok ? tracks.outliers : 0;
    health.keyframes = static_cast<int>(window.state().keyframes.size());
    health.landmarks = summary.fit.active_landmarks;
    health.iterations = health.is_keyframe ? summary.solver.iterations : 0;
    health.mean_vision_chi2 =
        summary.fit.vision_rows > 0 ? summary.fit.vision_squared_error / summary.fit.vision_rows : 0.0;
    health.imu_chi2 = summary.imu_squared_error / kStateDim;
    health.time_offset_s = window.calibration().time_offset_s;
    health.time_offset_sigma_s = time_offset_sigma_s;
    const ImuBufferCounters& counters = imu.counters();
    health.imu_gaps = counters.gaps;
    health.imu_dropped = counters.out_of_order + counters.not_finite;

    const ImuBias& bias = window.newest().state.bias;
    const auto raise = [&health](bool condition, HealthReason reason) { health.reasons |= condition ? reason : 0U; };
    raise(!image_ok, kReasonImageRejected);
    raise(image_ok && static_cast<int>(tracks.observations.size()) < kFewFeatures, kReasonFewFeatures);
    raise(health.is_keyframe && tracks.stereo < kFewStereo, kReasonFewStereo);
    raise(frame.right.empty(), kReasonNoRightImage);
    raise(has_gap, kReasonImuGap);
    raise(bias.gyro.norm() > kMaxGyroBias || bias.accel.norm() > kMaxAccelBias, kReasonBiasLimit);
    raise(health.mean_vision_chi2 > kHighVisionChi2, kReasonHighResidual);
    raise(summary.solver.solver_failed || summary.marginalization_failed, kReasonSolverFailed);

    const std::uint32_t degrading =
        kReasonFewFeatures | kReasonImageRejected | kReasonBiasLimit | kReasonHighResidual | kReasonSolverFailed;
    if (!is_ready) {
        health.state = TrackingState::kInit;
    } else if ((last_frame - last_vision).seconds() > kLostAfter || (health.reasons & kReasonBiasLimit) != 0U) {
        health.state = TrackingState::kLost;
    } else {
        health.state = (health.reasons & degrading) != 0U ? TrackingState::kDegraded : TrackingState::kTracking;
    }
}

Estimator::Estimator() : impl_(std::make_unique<Impl>()) {}
Estimator::~Estimator() = default;

Status Estimator::configure(const EstimatorConfig& config, const StereoRig& rig) {
    FACET_TRY(config.validate());
    FACET_TRY(CameraModel::validate(rig.left.intrinsics()));
    FACET_TRY(CameraModel::validate(rig.right.intrinsics()));
    FACET_TRY(impl_->frontend.configure(config.frontend, rig));
    impl_->config = config;
    impl_->rig = rig;
    impl_->reset();
    return Status::kOk;
}

void Estimator::set_stage_observer(StageObserver* observer) {
    impl_->observer = observer;
    impl_->window.set_stage_observer(observer);
}

Status Estimator::add_imu(const ImuSample& sample) { return impl_->imu.push(sample); }

Status Estimator::add_frame(const StereoFrame& frame, Estimate& estimate) {
    Impl& s = *impl_;
    const Timestamp stamp = s.imu_stamp(frame.stamp);
    if (s.has_frame && frame.stamp <= s.last_image) {
        return Status::kOutOfOrder;
    }
    if (s.imu.empty() || s.imu.newest() < stamp) {
        return Status::kNotReady;
    }
    if (s.window.empty()) {
        return s.start(frame, estimate);
    }
    Preintegration preintegration;
    bool has_gap = false;
    FACET_TRY(s.predict(stamp, preintegration, has_gap));
    const Status tracked = s.track(frame, stamp, s.window.newest().state.bias.gyro);
    s.has_frame = true;
    s.last_image = frame.stamp;
    s.last_frame = stamp;
    estimate = {};
    estimate.stamp = stamp;
    estimate.state = preintegration.predict(s.window.newest().state);
    if (ok(tracked)) {
        if (static_cast<int>(s.tracks.observations.size()) >= kFewFeatures) {
            s.last_vision = stamp;
        }
        if (s.tracks.is_keyframe) {
            s.take_keyframe(stamp, preintegration);
            estimate.state = s.window.newest().stamp == stamp ? s.window.newest().state : estimate.state;
        }
    }
    s.fill_health(frame, ok(tracked), has_gap, estimate.health);
    return tracked;
}

}  // namespace facet
