// SPDX-License-Identifier: BSD-2-Clause
// A keyframe's turn in the window: at once, or after the estimate of the frame that follows it.
#include <algorithm>
#include <cmath>

#include "estimator/flight/flight.h"
#include "estimator/values/stage_scope.h"

namespace facet {
namespace {

// Before the first estimate is reported the window may take more steps: its guess may be far off, and it is small. So
// may it while readings are suspected: a hard turn leads far from the steady motion that stands in for them.
constexpr double kFarEffort = 6.0;
// After a frame that came too late, up to the next keyframe: share of the solver's steps.
constexpr double kLateEffort = 0.5;
// A window with fewer keyframes is still finding out how fast the vehicle moves.
constexpr std::size_t kSettledKeyframes = 3;

}  // namespace

KeyframeInput FlightEstimator::keyframe_input() const {
    KeyframeInput input;
    input.stamp = s_.now.stamp;
    input.observations = {tracks_.observations.data(), tracks_.observations.size()};
    input.rests_since_previous = s_.rest.rests() && tracks_.is_still;
    input.images_rest = tracks_.is_still;
    ImuSample sample;
    if (ok(imu_.interpolate(s_.now.stamp, sample))) {
        input.w_B = sample.w_B - s_.now.state.bias.gyro;
    }
    input.ground_B = ranges_.ground_B(s_.now.stamp, s_.now.state, input.w_B);
    input.climb_sigma_m_per_s = std::sqrt(std::max(0.0, s_.newest.covariance(kVel + 2, kVel + 2)));
    return input;
}

double FlightEstimator::effort() const {
    const bool may_be_far = monitor_.state() == TrackingState::kInit || s_.fault.is_active();
    return may_be_far ? kFarEffort : (s_.is_late ? kLateEffort : 1.0);
}

void FlightEstimator::add_keyframe(Preintegration& preintegration, Phase before) {
    FrameEstimate seen;
    const bool is_seen = ok(examine_image(preintegration, seen));
    // Inertial samples lead astray: in a second of shaking by millimetres, far enough for the solver to end before it
    // has come back along the directions that only the prior holds, and by pixels in flight. What stands in for
    // suspected readings leads astray further still.
    const bool is_sound = is_seen && 2 * seen.agreeing > seen.landmarks;
    const NavState* guess = is_sound ? &seen.state : nullptr;
    if (is_seen && may_wait(before)) {
        let_wait(preintegration, seen, guess);
    } else {
        take_keyframe(preintegration, guess);
        s_.fit.chi2 = is_seen ? seen.chi2 : 0.0;
    }
}

bool FlightEstimator::enter_window(const KeyframeInput& input, const Preintegration& preintegration, double effort) {
    if (!ok(window_.add_keyframe(input, preintegration))) {
        return false;
    }
    s_.keyframe.summary = window_.optimize(effort);
    s_.keyframe.is_new = true;
    frontend_.drop_tracks(window_.rejected());
    s_.now.state = window_.newest().state;
    follow_fault();
    reintegrate();
    update_covariance();
    learn_vibration();
    s_.now.imu_scale = window_.calibration().imu;
    s_.now.vibration = vibration_.share();
    s_.newest = s_.now;
    static_cast<void>(window_.fill_map(map_));  // on failure it is empty: frames are predicted then
    s_.keyframe.view_is_open = true;
    return true;
}

void FlightEstimator::take_keyframe(const Preintegration& preintegration, const NavState* guess) {
    KeyframeInput input = keyframe_input();
    input.guess = guess;
    const Eigen::Vector3d predicted_W = s_.now.state.p_W_B;
    if (!enter_window(input, preintegration, effort())) {
        return;
    }
    s_.gauge.follow(monitor_.state() == TrackingState::kLost, s_.now.state.p_W_B - predicted_W);
    s_.rest.begin();
    s_.start.count_keyframe();
    if (monitor_.state() == TrackingState::kInit) {
        complete_view();  // while the window is as it was optimized
        continue_start(input);
    }
}

bool FlightEstimator::may_wait(Phase before) const {
    const bool is_calm = before == Phase::kFollowing && monitor_.state() == TrackingState::kTracking &&
                         !s_.fault.is_active() && !s_.restart_requested && !s_.span.has_gap && s_.span.clipped == 0;
    const bool is_under_way = window_.state().keyframes.size() >= kSettledKeyframes && s_.start.is_confirmed() &&
                              !s_.start.forces_keyframes() && s_.start.claim() == RestClaim::kNone && !tracks_.is_still;
    return config_.window.spread_keyframes && is_calm && is_under_way && tracks_.stereo >= HealthMonitor::kFewStereo;
}

void FlightEstimator::let_wait(const Preintegration& preintegration, const FrameEstimate& seen, const NavState* guess) {
    waiting_.is_set = true;
    waiting_.wants_view = false;
    waiting_.tracks = tracks_;
    waiting_.input = keyframe_input();
    waiting_.input.observations = {waiting_.tracks.observations.data(), waiting_.tracks.observations.size()};
    waiting_.predicted = s_.now;
    if (guess != nullptr) {
        waiting_.guess = *guess;
        waiting_.input.guess = &waiting_.guess;
    }
    waiting_.preintegration = preintegration;
    waiting_.span = s_.span;
    waiting_.effort = effort();
    s_.rest.begin();
    take_over(seen);
}

void FlightEstimator::take_waiting() {
    if (!waiting_.is_set) {
        return;
    }
    waiting_.is_set = false;
    const Belief last = s_.now;
    const ImuSpan span_since = s_.span;
    s_.now = waiting_.predicted;
    s_.span = waiting_.span;
    const bool is_taken = enter_window(waiting_.input, waiting_.preintegration, waiting_.effort);
    if (is_taken && waiting_.wants_view) {
        fill_view(waiting_.tracks);
    } else {
        close_view();
    }
    if (!is_taken || last.stamp > s_.now.stamp) {
        s_.now = last;
        s_.span = span_since;
        s_.now.imu_scale = window_.calibration().imu;
        s_.now.vibration = vibration_.share();
    }
}

void FlightEstimator::take_waiting(Preintegration& preintegration) {
    if (waiting_.is_set) {
        take_waiting();
        static_cast<void>(predict(s_.now.stamp, preintegration));  // within what the inertial history holds: as before
    }
}

void FlightEstimator::finish_frame() {
    if (!waiting_.is_set) {
        complete_view();
        return;
    }
    waiting_.wants_view = true;
    if (waits_at_newest_frame()) {
        const StageScope scope(observer_, Stage::kTracking);
        frontend_.match_surface(waiting_.tracks);
    } else {
        take_waiting();
    }
}

}  // namespace facet
