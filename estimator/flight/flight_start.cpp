// SPDX-License-Identifier: BSD-2-Clause
// The first window of a flight, and what tests it: a start in motion, or images that stand still.
#include "estimator/flight/belief_changes.h"
#include "estimator/flight/flight.h"
#include "estimator/imu/static_init.h"

namespace facet {
namespace {

// With one camera: if no start in motion has confirmed the velocity for this long, the window has gone astray.
constexpr double kFruitless_s = 2.0;

}  // namespace

void FlightEstimator::configure_starts() {
    const StereoRig& rig = cameras_.rig();
    // Twice the sigma of a sighting: its error repeats from keyframe to keyframe, and the lens is not exact.
    motion_start_.configure(rig, config_.imu_noise, gravity_m_per_s2_,
                            2.0 * config_.window.pixel_sigma_px / rig.left.focal_px());
}

Status FlightEstimator::start(const StereoFrame& frame, Estimate& estimate) {
    const Timestamp before = s_.now.stamp;
    s_.now.stamp = imu_stamp(frame.stamp);
    InitialState initial;
    if (!ok(initialize_state(imu_, s_.now.stamp, gravity_m_per_s2_, config_.initializer, initial))) {
        s_.now.stamp = before;
        report(frame, FrameUse::kTracked, estimate);  // INIT: not enough data before this frame
        return Status::kOk;
    }
    s_.now.state = initial.state;
    const Status tracked = track(frame, before, true);
    s_.phase = Phase::kWaiting;
    s_.frames.last_image = frame.stamp;
    s_.frames.last_frame = s_.now.stamp;
    if (ok(tracked) && tracks_.is_keyframe) {
        s_.now.covariance = initial.information().inverse();
        if (s_.trusted) {  // a clock has gone back, or an earlier program has kept its state
            fuse_biases(*s_.trusted, s_.now);
            begin_window_in_place_of(*s_.trusted);
            s_.resets.jump();
        } else {
            begin_window(initial.information(), CalibrationStart::kAsGiven);
        }
        monitor_.restart(s_.now.stamp, false);
        s_.start.begin_first(initial.is_still);
    }
    report(frame, ok(tracked) ? FrameUse::kTracked : FrameUse::kRefused, estimate);
    return tracked;
}

StillnessEvidence FlightEstimator::stillness() const {
    return {tracks_.image == ImageState::kUsable, monitor_.state() == TrackingState::kInit, tracks_.tracked,
            tracks_.rest_disparity_px, FrontendConfig::kStillDisparity_px};
}

void FlightEstimator::judge_rest() {
    const StillnessEvidence e = stillness();
    update_rest(e.is_usable);
    if (s_.start.can_judge_claim(e)) {
        InitialState again;
        const bool samples_rest =
            ok(initialize_state(imu_, s_.now.stamp, gravity_m_per_s2_, config_.initializer, again)) && again.is_still;
        s_.start.judge_claim(e, samples_rest, s_.now.stamp);
    }
    s_.start.judge_stand(e);
}

void FlightEstimator::continue_start(const KeyframeInput& input) {
    motion_start_.add_keyframe(s_.now.stamp, input.observations, imu_, s_.now);
    if (s_.start.may_stand()) {
        begin_shaken_rest();
    } else {
        check_start();
    }
}

void FlightEstimator::check_start() {
    NavState better;
    StateCovariance information;
    const bool is_monocular = tracks_.stereo < kStereoStart;
    const Status status = motion_start_.check(s_.now.state, better, information);
    if (!is_monocular || status == Status::kNotFound) {
        s_.start.confirm();
    }
    const Belief before = s_.now;
    if (ok(status)) {
        begin_window_at(better, information.inverse());
    } else if (!s_.start.is_confirmed() && s_.start.age_s(s_.now.stamp) > kFruitless_s && ok(fall_back_to_gravity())) {
        motion_start_.reset();
        begin_window_in_place_of(before);
    }
}

void FlightEstimator::collect_alone() {
    if (tracks_.stereo >= kStereoStart) {  // the other camera is back
        motion_start_.reset();
        begin_window(inverse(s_.now.covariance), calibration_start());
        return;
    }
    motion_start_.add_keyframe(s_.now.stamp, keyframe_input().observations, imu_, s_.now);
    NavState solved;
    StateCovariance information;
    const Belief before = s_.now;
    if (ok(motion_start_.solve(s_.now.state, solved, information))) {
        begin_window_at(solved, information.inverse());
    } else if (motion_start_.delay() && config_.calibration.estimate_time_offset &&
               delay_.propose(*motion_start_.delay(), image_delay_s())) {
        // The next frame restarts with it.
    } else if (ok(fall_back_to_gravity())) {
        keep_biases(before, s_.now);  // images have said nothing of them yet
        begin_window_in_place_of(before);
        s_.start.await_answer();
    }
}

void FlightEstimator::begin_shaken_rest() {
    if (!s_.start.stands_long_enough(s_.now.stamp)) {
        return;
    }
    s_.start.end_stand();
    const RestStretch rest{s_.start.window_began(), s_.now.stamp};
    InitialState initial;
    if (!ok(initialize_shaken(imu_, rest, gravity_m_per_s2_, config_.initializer, initial))) {
        return;
    }
    begin_window_at(initial.state, inverse(initial.information()));
    s_.start.begin_shaken_rest();
}

}  // namespace facet
