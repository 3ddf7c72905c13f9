// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/estimator.h"

#include <cmath>

#include "estimator/api/estimator_impl.h"
#include "estimator/api/keyframe_snapshot.h"
#include "estimator/factors/rest_factor.h"
#include "estimator/imu/static_init.h"
#include "estimator/imu/stationarity.h"
#include "estimator/window/stage_scope.h"

namespace facet {
namespace {

// An inertial factor is integrated anew when its bias has moved this far: then the first-order correction errs.
constexpr double kReintegrateGyro = 2e-3;   // rad/s
constexpr double kReintegrateAccel = 5e-2;  // m/s^2
// Before the first estimate is reported the window may take more steps: its guess may be far off, and it is small.
constexpr double kInitEffort = 4.0;
// After a frame that came too late, up to the next keyframe: shares of the solver's steps and of the features.
constexpr double kLateEffort = 0.5;
constexpr double kLateFeatures = 0.67;
// The front-end's order of the corrections is that of the calibration's tangent.
static_assert(CameraCorrections::kDim == kCameraTermsDim && kLeftLens == kRigDim &&
              kRightTheta == kLeftLens + kLensDim && kRightLens == kRightTheta + kPoseDim);

}  // namespace

void Estimator::Impl::reset() {
    imu.clear(config.imu_noise.rate_hz, config.imu_limits);
    frontend.reset();
    other_frontend.reset();
    window.configure(config.window, config.calibration, rig, config.imu_noise, config.regularity);
    monitor.configure(config.health);
    gravity_m_per_s2 = config.gravity.norm_m_per_s2();
    configure_starts();
    monitor.reset();
    tracks = {};
    newest = now = {};
    span = {};
    phase = Phase::kEmpty;
    rests = reset_wanted = is_late = is_blind = has_carried = false;
    has_frame = has_primary = false;
    is_confirmed = true;
    awaits_answer = has_trusted = false;
    trusted = {};
    gauge.setZero();
    q_Bf_B.setIdentity();
    frame_latency = {};
    calibration_sigma.setZero();
    forget_corrections();
    reset_counter = 0;
    summary = {};
    view.number = 0;
    view.landmarks.clear();
    view.surface.clear();
    view.keyframes.clear();
    view.planes.clear();
}

KeyframeInput Estimator::Impl::keyframe_input() const {
    KeyframeInput input;
    input.stamp = now.stamp;
    input.observations = {tracks.observations.data(), tracks.observations.size()};
    input.rests_since_previous = rests && tracks.is_still;
    ImuSample sample;
    if (ok(imu.interpolate(now.stamp, sample))) {
        input.w_B = sample.w_B - now.state.bias.gyro;
    }
    return input;
}

Status Estimator::Impl::track(const StereoFrame& frame, Timestamp before, bool wants_keyframe) {
    FrameHints hints;
    hints.wants_keyframe = wants_keyframe;
    hints.effort = is_late ? kLateFeatures : 1.0;
    if (phase != Phase::kEmpty) {
        const StageScope scope(observer, Stage::kPropagation);
        hints.q_Bp_B = turn_since_frame(before);
    }
    const StageScope scope(observer, Stage::kTracking);
    hints.landmarks = window.predict_landmarks(now.state);
    FACET_TRY(frontend.process(frame, hints, tracks));
    q_Bf_B.setIdentity();
    if (hook != nullptr) {
        hook->edit(frame.stamp, {tracks.observations.data(), tracks.observations.size()});
    }
    return Status::kOk;
}

Status Estimator::Impl::start(const StereoFrame& frame, Estimate& estimate) {
    const Timestamp before = now.stamp;
    now.stamp = imu_stamp(frame.stamp);
    InitialState initial;
    if (!ok(initialize_state(imu, now.stamp, gravity_m_per_s2, config.initializer, initial))) {
        now.stamp = before;
        report(frame, true, estimate);  // INIT: not enough data before this frame
        return Status::kOk;
    }
    now.state = initial.state;
    const Status tracked = track(frame, before, true);
    phase = Phase::kWaiting;
    last_image = frame.stamp;
    last_frame = now.stamp;
    if (ok(tracked) && tracks.is_keyframe) {
        now.covariance = initial.information().inverse();
        begin_window(initial.information());
        monitor.restart(now.stamp, initial.is_still);
    }
    report(frame, ok(tracked), estimate);
    return tracked;
}

Status Estimator::Impl::predict(Timestamp stamp, Preintegration& preintegration) {
    const StageScope scope(observer, Stage::kPropagation);
    Status status = Status::kNotFound;
    if (phase != Phase::kCoasting) {
        preintegration.reset(newest.state.bias);
        status = imu.integrate_between(newest.stamp, stamp, config.imu_noise, preintegration, &span);
    }
    const Belief from = ok(status) ? newest : now;
    if (!ok(status)) {
        phase = Phase::kCoasting;
        preintegration.reset(from.state.bias);
        FACET_TRY(imu.integrate_between(from.stamp, stamp, config.imu_noise, preintegration, &span));
    }
    now.stamp = stamp;
    now.state = preintegration.predict(from.state);
    now.covariance = propagate_covariance(from.state, from.covariance, preintegration, config.imu_noise);
    return Status::kOk;
}

void Estimator::Impl::judge_rest(bool image_is_still) {
    Stationarity stationarity;
    const Status known = measure_stationarity(imu, now.stamp, {config.imu_noise, now.state.bias, gravity_m_per_s2},
                                              config.stationarity, stationarity);
    rests = rests && image_is_still && ok(known) && stationarity.may_be_at_rest;
}

void Estimator::Impl::hold_still() {
    const RestSigmas sigmas;
    now.state.q_W_B = newest.state.q_W_B;
    now.state.p_W_B = newest.state.p_W_B;
    now.state.v_W_B.setZero();
    now.covariance = newest.covariance;
    now.covariance.middleRows<3>(kVel).setZero();
    now.covariance.middleCols<3>(kVel).setZero();
    now.covariance.diagonal().segment<3>(kTheta).array() += sigmas.theta_rad * sigmas.theta_rad;
    now.covariance.diagonal().segment<3>(kPos).array() += sigmas.p_m * sigmas.p_m;
    now.covariance.diagonal().segment<3>(kVel).setConstant(sigmas.v_m_per_s * sigmas.v_m_per_s);
}

void Estimator::Impl::take_keyframe(const Preintegration& preintegration) {
    if (!ok(window.add_keyframe(keyframe_input(), preintegration))) {
        return;
    }
    const bool is_starting = monitor.state() == TrackingState::kInit;
    summary = window.optimize(is_starting ? kInitEffort : (is_late ? kLateEffort : 1.0));
    frontend.drop_tracks(window.rejected());
    now.state = window.newest().state;
    reintegrate();
    update_covariance();
    update_corrections();
    newest = now;
    rests = true;
    {
        const StageScope scope(observer, Stage::kLandmarks);
        fill_keyframe_view(window, tracks, view);
        view.is_exchanged = is_exchanged;
    }
    if (is_starting) {
        motion_start.add_keyframe(now.stamp, keyframe_input().observations, imu);
        monocular_start.add_keyframe(now.stamp, keyframe_input().observations, imu, now.state.bias);
        second_opinion();
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
        const ImuBias& then = keyframes[k].imu_from_previous.preintegration().bias();
        const bool moved =
            (bias.gyro - then.gyro).norm() > kReintegrateGyro || (bias.accel - then.accel).norm() > kReintegrateAccel;
        Preintegration anew(bias, gravity_m_per_s2);
        if (moved && ok(imu.integrate_between(keyframes[k - 1].stamp, keyframes[k].stamp, config.imu_noise, anew))) {
            // It is refused only where the old factor would have been refused too, and that one was accepted.
            static_cast<void>(window.replace_imu_factor(static_cast<int>(k), anew));
        }
    }
}

Status Estimator::Impl::carry_on(const StereoFrame& frame, Timestamp stamp, Estimate& estimate) {
    const Timestamp before = now.stamp;
    Preintegration preintegration({}, gravity_m_per_s2);
    if (frontend.ids_run_out()) {
        frontend.restart_ids();
        reset_wanted = true;
    }
    FACET_TRY(predict(stamp, preintegration));
    PredictionEvidence predicted;
    predicted.phase = phase;
    predicted.is_lost = monitor.state() == TrackingState::kLost && config.health.auto_reset;
    predicted.reset_wanted = reset_wanted;
    predicted.inertial_data_poor = span.has_gap || span.clipped != 0;
    predicted.rests = rests;
    predicted.keyframe_age_s = (stamp - newest.stamp).seconds();
    const Status tracked = track(frame, before, wants_keyframe(predicted));
    last_image = frame.stamp;
    last_frame = stamp;
    if (ok(tracked)) {
        judge_rest(tracks.image == ImageState::kUsable);
        FrameEvidence seen{phase, must_restart(predicted), tracks.is_keyframe, tracks.stereo, rests, tracks.is_still};
        seen.lone_features = is_alone(frame) ? static_cast<int>(tracks.observations.size()) : 0;
        act(decide(seen), preintegration);
    }
    report(frame, ok(tracked), estimate);
    if (monitor.state() == TrackingState::kTracking || monitor.state() == TrackingState::kDegraded) {
        trusted = now;
        has_trusted = true;
    }
    return tracked;
}

void Estimator::Impl::act(FrameAction action, const Preintegration& preintegration) {
    switch (action) {
        case FrameAction::kCarryOn: break;
        case FrameAction::kTakeKeyframe:
            phase = Phase::kFollowing;
            if (awaits_answer) {
                collect_alone();
            } else {
                take_keyframe(preintegration);
            }
            break;
        case FrameAction::kHold:
            phase = Phase::kHolding;
            hold_still();
            break;
        case FrameAction::kRestart: restart_in_flight(); break;
    }
}

Estimator::Estimator() : impl_(std::make_unique<Impl>()) {}
Estimator::~Estimator() = default;

Status Estimator::configure(const EstimatorConfig& config, const StereoRig& rig) {
    FACET_TRY(config.validate());
    FACET_TRY(CameraModel::validate(rig.left.intrinsics()));
    FACET_TRY(CameraModel::validate(rig.right.intrinsics()));
    FACET_TRY(impl_->frontend.configure(config.frontend, rig));
    FACET_TRY(impl_->other_frontend.configure(config.frontend, rig.exchanged()));
    impl_->config = config;
    impl_->rig = rig;
    impl_->is_exchanged = false;
    impl_->reset();
    return Status::kOk;
}

void Estimator::set_observation_hook(ObservationHook* hook) { impl_->hook = hook; }

void Estimator::set_stage_observer(StageObserver* observer) {
    impl_->observer = observer;
    impl_->window.set_stage_observer(observer);
}

void Estimator::request_reset() { impl_->reset_wanted = has_window(impl_->phase); }

void Estimator::report_overrun() { impl_->is_late = true; }

void Estimator::set_planes(const PlaneProposals& planes) { impl_->window.set_planes(planes); }

std::span<const MemoryPart> Estimator::memory() {
    static_assert(sizeof(Impl) <= kMemoryBudget / 2, "the other half is for images, mesh and planes");
    static constexpr MemoryPart kParts[] = {{"window", sizeof(Window)},
                                            {"inertial history", sizeof(ImuBuffer)},
                                            {"front-end", 2 * sizeof(Frontend) + sizeof(FrontendOutput)},
                                            {"start in motion", sizeof(MotionStart) + sizeof(MonocularStart)},
                                            {"landmark view", sizeof(KeyframeView)}};
    return kParts;
}

const KeyframeView& Estimator::keyframe_view() const { return impl_->view; }

CalibrationEstimate Estimator::calibration() const {
    CalibrationEstimate estimate;
    estimate.correction = impl_->calibration_as_given();
    for (int i = 0; i < impl_->config.calibration.dim() && impl_->window.has_factor(); ++i) {
        estimate.sigma(i) = impl_->window.calibration_sigma(i);
    }
    if (impl_->is_exchanged) {
        estimate.sigma.segment<kLensDim>(kLeftLens).swap(estimate.sigma.segment<kLensDim>(kRightLens));
    }
    return estimate;
}

const VisionResiduals& Estimator::residuals() const { return impl_->window.residuals(); }

Status Estimator::add_imu(const ImuSample& sample) {
    FACET_TRY(impl_->imu.push(sample));
    impl_->carry_without_frames();
    return Status::kOk;
}

Status Estimator::take_carried(Estimate& estimate) {
    if (!impl_->has_carried) {
        return Status::kNotReady;
    }
    impl_->has_carried = false;
    estimate = impl_->carried;
    return Status::kOk;
}

Status Estimator::add_frame(const StereoFrame& frame, Estimate& estimate) {
    Impl& s = *impl_;
    if (!ImuBuffer::is_sane(frame.stamp)) {
        return Status::kInvalidArgument;
    }
    const Timestamp stamp = s.imu_stamp(frame.stamp);
    if (s.phase != Phase::kEmpty && (frame.stamp <= s.last_image || stamp <= s.now.stamp)) {
        s.expect_late_frames(frame.stamp, stamp);
        return Status::kOutOfOrder;
    }
    if (s.imu.empty() || s.imu.newest() < stamp) {
        return Status::kNotReady;
    }
    const StereoFrame seen = s.choose_camera(frame);
    if (seen.left.empty() && !seen.right.empty()) {
        return s.pass_over(frame, stamp, estimate);
    }
    return has_window(s.phase) ? s.carry_on(seen, stamp, estimate) : s.start(seen, estimate);
}

}  // namespace facet
