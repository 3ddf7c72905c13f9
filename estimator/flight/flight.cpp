// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/flight.h"

#include <algorithm>
#include <cmath>

#include "estimator/flight/belief_changes.h"
#include "estimator/frontend/image_check.h"
#include "estimator/values/stage_scope.h"

namespace facet {
namespace {

// After a frame that came too late, up to the next keyframe: share of the features.
constexpr double kLateFeatures = 0.67;
// A window that has begun anew in flight gets so many keyframes as fast as a start: until then only inertial samples
// tell its velocity, and a vehicle that stands would show no other reason for one for a second.
constexpr std::size_t kKeyframesOfStart = 3;
// Of the turn between two images by a hundred points: 0.2 mrad in four sequences with 450 px of focal length.
constexpr double kTurnSigma_px = 0.09;
// While the delay's standard deviation is above this share of what is given, the window has not seen it yet.
constexpr double kFoundDelay = 0.5;
// So soon after the first start a wrong delay is more likely than a fault. After 40 turns none was found wrongly in
// 1300 stretches of four sequences, half of them under rotors.
constexpr double kYoung_s = 2.0;

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

Status FlightEstimator::configure(const EstimatorConfig& config, const StereoRig& rig) {
    FACET_TRY(config.validate());
    FACET_TRY(CameraModel::validate(rig.left.intrinsics()));
    FACET_TRY(CameraModel::validate(rig.right.intrinsics()));
    FACET_TRY(frontend_.configure(config.frontend, rig));
    FACET_TRY(other_frontend_.configure(config.frontend, rig.exchanged()));
    config_ = config;
    gravity_m_per_s2_ = config.gravity.magnitude_m_per_s2;
    cameras_ = CameraRoles(rig);
    s_ = {};
    imu_.clear(config.imu_noise.rate_hz, config.imu_limits);
    ranges_.clear();
    vibration_.reset();
    imu_.believe(vibration_.share());
    frontend_.reset();
    other_frontend_.reset();
    tracks_ = {};
    window_.configure(config.window, config.calibration, rig, config.imu_noise, config.regularity, config.range);
    map_.clear();
    monitor_.configure(config.health);
    monitor_.reset();
    configure_starts();
    delay_.configure(kTurnSigma_px / rig.left.focal_px());
    forget_corrections();
    waiting_.is_set = false;
    view_.clear();
    return Status::kOk;
}

std::span<const MemoryPart> FlightEstimator::memory() {
    static_assert(sizeof(FlightEstimator) <= kMemoryBudget / 2, "the other half is for images, mesh and planes");
    static constexpr MemoryPart kParts[] = {{"window", sizeof(Window)},
                                            {"inertial history", sizeof(ImuBuffer)},
                                            {"front-end", 2 * sizeof(Frontend) + sizeof(FrontendOutput)},
                                            {"start in motion", sizeof(MotionStart)},
                                            {"frames between keyframes", sizeof(LocalMap) + sizeof(FrameUpdate)},
                                            {"keyframe that waits", sizeof(WaitingKeyframe)},
                                            {"landmark view", sizeof(KeyframeView)}};
    return kParts;
}

Status FlightEstimator::set_masks(const ImageView& left, const ImageView& right) {
    FACET_TRY(frontend_.set_masks(left, right));
    return other_frontend_.set_masks(right, left);
}

void FlightEstimator::set_stage_observer(StageObserver* observer) {
    observer_ = observer;
    window_.set_stage_observer(observer);
}

void FlightEstimator::request_reset() {
    if (has_window(s_.phase)) {
        s_.restart_requested = true;
    }
}

Status FlightEstimator::add_imu(const ImuSample& sample, ImuAxisMask clipped) {
    const Status status = imu_.push(sample, clipped);
    if (status == Status::kOutOfOrder && !imu_.has(sample)) {
        s_.clocks.refuse_sample(sample.stamp);
        if (s_.clocks.is_new_clock(imu_.newest())) {
            begin_on_new_clock();
            return imu_.push(sample, clipped);
        }
    }
    FACET_TRY(status);
    if (has_window(s_.phase)) {
        const double lost_s = s_.clocks.take_time_without_samples_s();
        if (lost_s > 0.0) {  // the motion in it is unknown
            s_.gauge.widen(s_.now.state, s_.fault.rate_B(), lost_s);
            s_.clocks.lose(lost_s);
            s_.restart_requested = true;
        }
        carry_without_frames();
    }
    return Status::kOk;
}

Status FlightEstimator::add_range(const RangeSample& sample) {
    return config_.range.enabled ? ranges_.push(sample) : Status::kOk;
}

Status FlightEstimator::add_frame(const StereoFrame& frame, Estimate& estimate) {
    if (!ImuBuffer::is_sane(frame.stamp)) {
        return Status::kInvalidArgument;
    }
    if (!waits_at_newest_frame() || s_.restart_requested || monitor_.state() != TrackingState::kTracking) {
        take_waiting();  // first of all: it may move the clocks' offset
    }
    correct_delay();
    const Timestamp stamp = imu_stamp(frame.stamp);
    s_.clocks.offer(stamp);
    FACET_TRY(check_order(frame.stamp, stamp));
    if (imu_.empty() || imu_.newest() < stamp) {
        return Status::kNotReady;
    }
    const double repeated_s = s_.clocks.take_time_without_frames_s();
    if (has_window(s_.phase) && repeated_s > 0.0) {
        s_.gauge.widen(s_.now.state, s_.fault.rate_B(), repeated_s);
    }
    if (cameras_.must_exchange(frame)) {
        exchange_cameras();
    }
    const StereoFrame seen = cameras_.step(frame);
    if (seen.left.empty() && !seen.right.empty()) {
        return pass_over(frame, stamp, FrameUse::kMissing, estimate);
    }
    if (s_.emitter.step(relative_contrast(seen.left))) {
        return pass_over(frame, stamp, FrameUse::kLeftOut, estimate);
    }
    return has_window(s_.phase) ? carry_on(seen, stamp, estimate) : start(seen, estimate);
}

Status FlightEstimator::check_order(Timestamp image, Timestamp stamp) {
    const FrameTimes& frames = s_.frames;
    if (s_.phase == Phase::kEmpty || (image > frames.last_image && stamp > std::max(s_.now.stamp, frames.last_frame))) {
        return Status::kOk;
    }
    if (image <= frames.last_image) {
        s_.clocks.refuse_frame(image);
    } else if (has_window(s_.phase) && stamp > frames.last_frame && imu_.newest() > stamp) {
        s_.frames.expect_late(imu_.newest() - stamp);
    }
    return Status::kOutOfOrder;
}

Status FlightEstimator::take_carried(Estimate& estimate) {
    if (!s_.carried) {
        return Status::kNotReady;
    }
    estimate = *s_.carried;
    s_.carried.reset();
    return Status::kOk;
}

Status FlightEstimator::carry_on(const StereoFrame& frame, Timestamp stamp, Estimate& estimate) {
    const Timestamp before = s_.now.stamp;
    s_.gauge.begin_frame();
    Preintegration preintegration = preintegration_from({});
    if (frontend_.ids_run_out()) {
        frontend_.restart_ids();
        s_.restart_requested = true;
    }
    replace_readings(stamp);
    FACET_TRY(predict(stamp, preintegration));
    const PredictionEvidence predicted = prediction_evidence(frame);
    const Status tracked = track(frame, before, wants_keyframe(predicted));
    s_.frames.last_image = frame.stamp;
    s_.frames.last_frame = stamp;
    if (ok(tracked)) {
        if (tracks_.shows_dots) {
            take_out_dots(preintegration);
        }
        judge_rest();
        FrameEvidence seen{s_.phase,       must_restart(predicted), tracks_.is_keyframe,
                           tracks_.stereo, s_.rest.rests(),         tracks_.is_still};
        seen.lone_features = cameras_.is_alone(frame) ? static_cast<int>(tracks_.observations.size()) : 0;
        drop_unsupported_fault(preintegration);
        act(decide(seen), preintegration);
    }
    s_.fault.see(stamp, s_.now.state);
    s_.now.replaced = s_.fault.readings(s_.now.state, gravity_m_per_s2_);
    report(frame, ok(tracked) ? FrameUse::kTracked : FrameUse::kRefused, estimate);
    const SlipEvidence slip{(estimate.health.reasons & kReasonHighResidual) != 0, tracks_.is_keyframe, stamp,
                            (stamp - before).seconds()};
    if (s_.gauge.step(slip, s_.now.state, s_.fault.rate_B())) {
        estimate.covariance = reported_covariance();
    }
    if (monitor_.is_usable()) {
        s_.trusted = s_.now;
        s_.resets.give();
    }
    return tracked;
}

PredictionEvidence FlightEstimator::prediction_evidence(const StereoFrame& frame) const {
    PredictionEvidence e;
    e.phase = s_.phase;
    e.is_lost = monitor_.state() == TrackingState::kLost && config_.health.auto_reset;
    e.is_beyond_recovery = monitor_.needs_restart() && config_.health.auto_reset;
    e.reset_wanted = s_.restart_requested || s_.start.claim() == RestClaim::kRefuted;
    e.inertial_data_poor = s_.span.has_gap || s_.span.clipped != 0;
    e.rests = s_.rest.rests();
    const bool begins_anew = s_.start.is_renewed() && window_.state().keyframes.size() < kKeyframesOfStart;
    const bool is_young = monitor_.state() == TrackingState::kInit || begins_anew || s_.start.forces_keyframes();
    e.is_starting = is_young && s_.start.is_confirmed() && !frame.right.empty() && s_.start.claim() == RestClaim::kNone;
    e.is_replaced = s_.fault.is_active() && (imu_.hanging() & s_.fault.axes()) == 0;
    e.keyframe_age_s = (s_.now.stamp - s_.newest.stamp).seconds();
    return e;
}

Status FlightEstimator::track(const StereoFrame& frame, Timestamp before, bool wants_keyframe) {
    close_view();
    FrameHints hints;
    hints.wants_keyframe = wants_keyframe;
    hints.effort = s_.is_late ? kLateFeatures : 1.0;
    hints.is_starting = monitor_.state() == TrackingState::kInit;
    hints.is_uncertain = monitor_.state() != TrackingState::kTracking;
    hints.is_contradicted = monitor_.is_contradicted();
    hints.replaces_both = s_.fault.axes() == (kGyroAxes | kAccelAxes) && !s_.fault.has_hung();
    hints.wants_turn = seeks_delay() || may_seek_delay();
    if (s_.phase != Phase::kEmpty) {
        const StageScope scope(observer_, Stage::kPropagation);
        hints.q_Bp_B = turn_since_frame(before);
        if (s_.fault.is_active()) {
            imu_.exchange_as_read();
            hints.is_replaced =
                ok(imu_.rotation_between(before, s_.now.stamp, s_.now.state.bias.gyro, hints.q_Bp_B_as_read));
            imu_.exchange_as_read();
        }
    }
    const StageScope scope(observer_, Stage::kTracking);
    WindowLandmarks landmarks(window_, s_.now.state);
    hints.landmarks = &landmarks;
    FACET_TRY(frontend_.process(frame, hints, tracks_));
    if (tracks_.has_turn && s_.phase != Phase::kEmpty) {
        delay_.add(tracks_.turn_begin, frame.stamp, tracks_.turn_B);
    }
    examine_delay(frame.stamp);
    s_.frames.q_Bf_B.setIdentity();
    s_.stereo.step(tracks_.is_keyframe, tracks_.stereo, HealthMonitor::kFewStereo);
    if (hook_ != nullptr) {
        hook_->edit(frame.stamp, {tracks_.observations.data(), tracks_.observations.size()});
    }
    return Status::kOk;
}

void FlightEstimator::act(FrameAction action, Preintegration& preintegration) {
    s_.fit = {};
    if (action != FrameAction::kCarryOn) {
        take_waiting(preintegration);
    }
    const Phase before = s_.phase;
    switch (action) {
        case FrameAction::kCarryOn: update_by_image(preintegration); break;
        case FrameAction::kTakeKeyframe:
            s_.phase = Phase::kFollowing;
            s_.start.settle_claim();
            if (s_.start.awaits_answer()) {
                collect_alone();
            } else {
                add_keyframe(preintegration, before);
            }
            break;
        case FrameAction::kHold:
            s_.phase = Phase::kHolding;
            hold_at(s_.newest, s_.now);
            break;
        case FrameAction::kRestart:
            if (s_.start.claim() == RestClaim::kRefuted) {
                restart_in_motion();
            } else {
                restart_in_flight();
            }
            break;
    }
}

Status FlightEstimator::predict(Timestamp stamp, Preintegration& preintegration) {
    const StageScope scope(observer_, Stage::kPropagation);
    Status status = Status::kNotFound;
    if (s_.phase != Phase::kCoasting) {
        preintegration.reset(s_.newest.state.bias);
        status = imu_.integrate_between(s_.newest.stamp, stamp, config_.imu_noise, preintegration, &s_.span);
    }
    const Belief from = ok(status) ? s_.newest : s_.now;
    if (!ok(status)) {
        s_.phase = Phase::kCoasting;
        preintegration.reset(from.state.bias);
        FACET_TRY(imu_.integrate_between(from.stamp, stamp, config_.imu_noise, preintegration, &s_.span));
    }
    s_.now.stamp = stamp;
    s_.now.state = preintegration.predict(from.state);
    s_.now.covariance = propagate_covariance(from.state, from.covariance, preintegration, config_.imu_noise);
    return Status::kOk;
}

Preintegration FlightEstimator::preintegration_from(const ImuBias& bias) const {
    Preintegration preintegration(bias, gravity_m_per_s2_);
    preintegration.set_scale(window_.calibration().imu, config_.calibration.estimate_imu);
    return preintegration;
}

bool FlightEstimator::is_delay_as_given() const {
    const double sigma_s = s_.calibration_sigma(kTimeOffset);
    const bool is_first = s_.resets.is_first_start() && !s_.trusted;  // nor has an earlier program given an estimate
    const bool is_as_given = sigma_s == 0.0 || sigma_s > kFoundDelay * config_.calibration.time_offset_sigma_s;
    return is_first || (monitor_.state() == TrackingState::kTracking && is_as_given);
}

bool FlightEstimator::is_delay_new() const {
    return is_delay_as_given() || (s_.resets.value() == 0 && s_.start.age_s(s_.now.stamp) < kYoung_s);
}

bool FlightEstimator::seeks_delay() const {
    return config_.calibration.estimate_time_offset &&
           delay_.is_open(window_.calibration().time_offset_s, config_.calibration.time_offset_sigma_s,
                          monitor_.state() == TrackingState::kTracking, !s_.stereo.is_unmatched());
}

bool FlightEstimator::may_seek_delay() const {
    return config_.calibration.estimate_time_offset && !s_.stereo.is_unmatched() && is_delay_new();
}

void FlightEstimator::examine_delay(Timestamp image) {
    const bool is_new = is_delay_new();
    if (!seeks_delay() || !(is_new || tracks_.is_keyframe) || !tracks_.has_turn || !has_window(s_.phase)) {
        delay_.skip();
        return;
    }
    double claimed_s = monitor_.is_usable() ? s_.calibration_sigma(kTimeOffset) : 0.0;
    if (is_new && monitor_.state() == TrackingState::kTracking) {  // the window can follow less
        claimed_s = std::max(claimed_s, config_.calibration.time_offset_sigma_s);
    }
    imu_.exchange_as_read();  // of the suspected readings as well
    delay_.step(imu_, is_delay_as_given() ? delay_.found_s() : image_delay_s(), claimed_s, image, is_new);
    imu_.exchange_as_read();
}

void FlightEstimator::correct_delay() {
    if (const std::optional<double> off_s = delay_.accept(image_delay_s())) {
        window_.forget_calibration();
        forget_corrections();
        if (has_window(s_.phase) && monitor_.is_usable()) {
            move_images(*off_s);
        } else {
            begin_like_first(std::abs(*off_s));
        }
    }
}

}  // namespace facet
