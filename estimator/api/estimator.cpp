// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/estimator.h"

#include "estimator/api/estimator_impl.h"
#include "estimator/imu/static_init.h"
#include "estimator/window/stage_scope.h"

namespace facet {
namespace {

// After a frame that came too late, up to the next keyframe: share of the features.
constexpr double kLateFeatures = 0.67;
// A window that has begun anew in flight gets so many keyframes as fast as a start: until then only inertial samples
// tell its velocity, and a vehicle that stands would show no other reason for one for a second.
constexpr std::size_t kKeyframesOfStart = 3;

/// The window's landmarks as seen from a state.
class WindowLandmarks final : public LandmarkSource {
public:
    WindowLandmarks(Window& window, const NavState& state) : window_(window), state_(state) {}
    std::span<const LandmarkPrediction> predict() override { return window_.predict_landmarks(state_); }

private:
    Window& window_;
    const NavState& state_;
};

}  // namespace

void Estimator::Impl::reset() {
    imu.clear(config.imu_noise.rate_hz, config.imu_limits);
    vibration.reset();
    imu.believe(vibration.share());
    frontend.reset();
    other_frontend.reset();
    window.configure(config.window, config.calibration, rig, config.imu_noise, config.regularity);
    monitor.configure(config.health);
    gravity_m_per_s2 = config.gravity.norm_m_per_s2();
    delay_search.reset();
    is_delay_settled = false;
    found_delay_s = 0.0;
    map.clear();
    map_landmarks = 0;
    frame_chi2 = 0.0;
    configure_starts();
    monitor.reset();
    tracks = {};
    newest = now = {};
    span = {};
    phase = Phase::kEmpty;
    rests = reset_wanted = is_late = is_blind = has_carried = false;
    may_stand = is_unmatched = false;
    hastened = 0;
    has_frame = has_primary = false;
    is_confirmed = true;
    awaits_answer = has_trusted = has_given = is_renewed = false;
    trusted = {};
    gauge = drift = {};
    slip = {};
    q_Bf_B.setIdentity();
    frame_latency = {};
    calibration_sigma.setZero();
    forget_corrections();
    doubt = {};
    refused_samples = refused_frames = {};
    has_offered = false;
    is_bent = false;
    straight_keyframes = 0;
    lost_time_s = 0.0;
    reset_counter = 0;
    summary = {};
    summary_is_new = false;
    waiting.is_set = false;
    view_is_open = false;
    view.number = 0;
    view.landmarks.clear();
    view.surface.clear();
    view.keyframes.clear();
    view.planes.clear();
}

Status Estimator::Impl::track(const StereoFrame& frame, Timestamp before, bool wants_keyframe) {
    close_view();
    FrameHints hints;
    hints.wants_keyframe = wants_keyframe;
    hints.effort = is_late ? kLateFeatures : 1.0;
    hints.is_doubtful = monitor.state() != TrackingState::kTracking;
    hints.is_contradicted = monitor.is_contradicted();
    hints.doubts_both = doubt.axes() == (kGyroAxes | kAccelAxes) && !doubt.has_hung();
    hints.wants_turn = seeks_delay();
    if (phase != Phase::kEmpty) {
        const StageScope scope(observer, Stage::kPropagation);
        hints.q_Bp_B = turn_since_frame(before);
        if (doubt.is_active()) {
            imu.exchange_read();
            hints.is_replaced = ok(imu.rotation_between(before, now.stamp, now.state.bias.gyro, hints.q_Bp_B_as_read));
            imu.exchange_read();
        }
    }
    const StageScope scope(observer, Stage::kTracking);
    WindowLandmarks landmarks(window, now.state);
    hints.landmarks = &landmarks;
    FACET_TRY(frontend.process(frame, hints, tracks));
    if (tracks.has_turn_error && phase != Phase::kEmpty) {
        delay_search.add(last_image, frame.stamp, so3_log(hints.q_Bp_B) + tracks.turn_error_B);
    }
    q_Bf_B.setIdentity();
    judge_witness();
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
        if (has_trusted) {  // a clock has gone back, or an earlier program has kept its state
            fuse_trusted_bias();
            begin_window_in_place_of(trusted);
            count_reset();
        } else {
            begin_window(initial.information(), CalibrationStart::kAsGiven);
        }
        monitor.restart(now.stamp, false);
        rest_claim = initial.is_still ? RestClaim::kOpen : RestClaim::kNone;
        may_stand = !initial.is_still;
    }
    report(frame, ok(tracked), estimate);
    return tracked;
}

Preintegration Estimator::Impl::preintegration_from(const ImuBias& bias) const {
    Preintegration preintegration(bias, gravity_m_per_s2);
    preintegration.set_scale(window.calibration().imu, config.calibration.estimate_imu);
    return preintegration;
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

Status Estimator::Impl::carry_on(const StereoFrame& frame, Timestamp stamp, Estimate& estimate) {
    const Timestamp before = now.stamp;
    is_compared = false;
    Preintegration preintegration = preintegration_from({});
    if (frontend.ids_run_out()) {
        frontend.restart_ids();
        reset_wanted = true;
    }
    replace_doubted(stamp);
    FACET_TRY(predict(stamp, preintegration));
    PredictionEvidence predicted;
    predicted.phase = phase;
    predicted.is_lost = monitor.state() == TrackingState::kLost && config.health.auto_reset;
    predicted.is_beyond_recovery = monitor.needs_restart() && config.health.auto_reset;
    predicted.reset_wanted = reset_wanted || rest_claim == RestClaim::kRefuted;
    predicted.inertial_data_poor = span.has_gap || span.clipped != 0;
    predicted.rests = rests;
    const bool begins_anew = is_renewed && window.state().keyframes.size() < kKeyframesOfStart;
    predicted.is_starting = (monitor.state() == TrackingState::kInit || begins_anew || hastened > 0) && is_confirmed &&
                            !frame.right.empty() && rest_claim == RestClaim::kNone;
    predicted.is_doubted = doubt.is_active() && (imu.hanging() & doubt.axes()) == 0;
    predicted.keyframe_age_s = (stamp - newest.stamp).seconds();
    const Status tracked = track(frame, before, wants_keyframe(predicted));
    last_image = frame.stamp;
    last_frame = stamp;
    if (ok(tracked)) {
        judge_rest(tracks.image == ImageState::kUsable);
        judge_rest_claim();
        judge_shaken_rest();
        FrameEvidence seen{phase, must_restart(predicted), tracks.is_keyframe, tracks.stereo, rests, tracks.is_still};
        seen.lone_features = is_alone(frame) ? static_cast<int>(tracks.observations.size()) : 0;
        drop_doubt_without_witness(preintegration);
        act(decide(seen), preintegration);
    }
    doubt.see(stamp, now.state);
    now.doubted = doubt.readings(now.state, gravity_m_per_s2);
    report(frame, ok(tracked), estimate);
    if (judge_slip((stamp - before).seconds(), (estimate.health.reasons & kReasonHighResidual) != 0)) {
        estimate.covariance = reported_covariance();
    }
    if (monitor.is_usable()) {
        trusted = now;
        has_trusted = has_given = true;
    }
    return tracked;
}

void Estimator::Impl::act(FrameAction action, Preintegration& preintegration) {
    map_landmarks = 0;
    frame_chi2 = 0.0;
    if (action != FrameAction::kCarryOn) {
        take_waiting(preintegration);
    }
    const Phase before = phase;
    switch (action) {
        case FrameAction::kCarryOn: update_by_image(preintegration); break;
        case FrameAction::kTakeKeyframe:
            phase = Phase::kFollowing;
            rest_claim = rest_claim == RestClaim::kSeen ? RestClaim::kNone : rest_claim;
            if (awaits_answer) {
                collect_alone();
            } else {
                FrameEstimate seen;
                const bool is_seen = ok(examine_image(preintegration, seen));
                // Inertial samples lead astray: in a second of shaking by millimetres, far enough for the solver to end
                // before it has come back along the directions that only the prior holds, and by pixels in flight. What
                // stands in for readings in doubt leads astray further still.
                const bool is_sound = is_seen && 2 * seen.agreeing > seen.landmarks;
                const NavState* guess = is_sound ? &seen.state : nullptr;
                if (is_seen && may_wait(before)) {
                    let_wait(preintegration, seen, guess);
                } else {
                    take_keyframe(preintegration, guess);
                    frame_chi2 = is_seen ? seen.chi2 : 0.0;
                }
            }
            break;
        case FrameAction::kHold:
            phase = Phase::kHolding;
            hold_still();
            break;
        case FrameAction::kRestart:
            if (rest_claim == RestClaim::kRefuted) {
                restart_in_motion();
            } else {
                restart_in_flight();
            }
            break;
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

Status Estimator::set_masks(const ImageView& left, const ImageView& right) {
    FACET_TRY(impl_->frontend.set_masks(left, right));
    return impl_->other_frontend.set_masks(right, left);
}

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
                                            {"frames between keyframes", sizeof(LocalMap) + sizeof(FrameUpdate)},
                                            {"keyframe that waits", sizeof(WaitingKeyframe)},
                                            {"landmark view", sizeof(KeyframeView)}};
    return kParts;
}

const Belief& Estimator::belief() const { return impl_->now; }

void Estimator::finish_frame() { impl_->finish_frame(); }

bool Estimator::keyframe_waits() const { return impl_->waits_at_newest_frame(); }

const KeyframeView& Estimator::keyframe_view() const { return impl_->view; }

const VisionResiduals& Estimator::residuals() const { return impl_->window.residuals(); }

Status Estimator::add_imu(const ImuSample& sample) {
    return add_imu(sample, impl_->config.imu_limits.clipped_axes(sample));
}

Status Estimator::add_imu(const ImuSample& sample, ImuAxisMask clipped) {
    const Status status = impl_->imu.push(sample, clipped);
    if (status == Status::kOutOfOrder && !impl_->imu.has(sample)) {
        impl_->refused_samples.add(sample.stamp);
        if (impl_->is_on_new_clock()) {
            impl_->begin_on_new_clock();
            return impl_->imu.push(sample, clipped);
        }
    }
    FACET_TRY(status);
    if (has_window(impl_->phase)) {
        impl_->allow_for_lost_time(impl_->refused_samples.take_s());
    }
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
    if (!s.waits_at_newest_frame() || s.reset_wanted || s.monitor.state() != TrackingState::kTracking) {
        s.take_waiting();  // first of all: it may move the clocks' offset
    }
    if (!s.is_delay_settled && s.delay_search.is_ready() && s.tracks.is_keyframe && has_window(s.phase)) {
        s.settle_delay();
    }
    const Timestamp stamp = s.imu_stamp(frame.stamp);
    s.offered = stamp;
    s.has_offered = true;
    if (s.phase != Phase::kEmpty && (frame.stamp <= s.last_image || stamp <= s.now.stamp)) {
        s.expect_late_frames(frame.stamp, stamp);
        if (frame.stamp <= s.last_image) {
            s.refused_frames.add(frame.stamp);
        }
        return Status::kOutOfOrder;
    }
    if (s.imu.empty() || s.imu.newest() < stamp) {
        return Status::kNotReady;
    }
    const double repeated_s = s.refused_frames.take_s();
    if (has_window(s.phase) && repeated_s > RefusedRun::kLeast_s) {
        s.widen_gauge(repeated_s);
    }
    const StereoFrame seen = s.choose_camera(frame);
    if (seen.left.empty() && !seen.right.empty()) {
        return s.pass_over(frame, stamp, estimate);
    }
    return has_window(s.phase) ? s.carry_on(seen, stamp, estimate) : s.start(seen, estimate);
}

}  // namespace facet
