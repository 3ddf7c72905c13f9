// SPDX-License-Identifier: BSD-2-Clause
// How a keyframe waits for its turn in the window until the frame after it has its estimate.
#include "estimator/api/estimator_impl.h"
#include "estimator/window/stage_scope.h"

namespace facet {
namespace {

// A window with fewer keyframes is still finding out how fast the vehicle moves.
constexpr std::size_t kSettledKeyframes = 3;

}  // namespace

bool Estimator::Impl::may_wait(Phase before) const {
    const bool is_calm = before == Phase::kFollowing && monitor.state() == TrackingState::kTracking &&
                         !doubt.is_active() && !is_bent && !reset_wanted && !span.has_gap && span.clipped == 0;
    const bool is_under_way = window.state().keyframes.size() >= kSettledKeyframes && is_confirmed && hastened == 0 &&
                              rest_claim == RestClaim::kNone && !tracks.is_still;
    return config.window.spread_keyframes && is_calm && is_under_way && tracks.stereo >= HealthMonitor::kFewStereo;
}

void Estimator::Impl::let_wait(const Preintegration& preintegration, const FrameEstimate& seen, const NavState* guess) {
    waiting.is_set = true;
    waiting.wants_view = false;
    waiting.tracks = tracks;
    waiting.input = keyframe_input();
    waiting.input.observations = {waiting.tracks.observations.data(), waiting.tracks.observations.size()};
    waiting.predicted = now;
    if (guess != nullptr) {
        waiting.guess = *guess;
        waiting.input.guess = &waiting.guess;
    }
    waiting.preintegration = preintegration;
    waiting.span = span;
    waiting.effort = effort();
    rests = true;
    take_over(seen);
}

void Estimator::Impl::take_waiting() {
    if (!waiting.is_set) {
        return;
    }
    waiting.is_set = false;
    const Belief last = now;
    const ImuSpan span_since = span;
    now = waiting.predicted;
    span = waiting.span;
    const bool is_taken = enter_window(waiting.input, waiting.preintegration, waiting.effort);
    if (is_taken && waiting.wants_view) {
        fill_view(waiting.tracks);
    } else {
        close_view();
    }
    if (!is_taken || last.stamp > now.stamp) {
        now = last;
        span = span_since;
        now.imu_scale = window.calibration().imu;
        now.vibration = vibration.share();
    }
}

void Estimator::Impl::take_waiting(Preintegration& preintegration) {
    if (waiting.is_set) {
        take_waiting();
        static_cast<void>(predict(now.stamp, preintegration));  // within what the inertial history holds: as before
    }
}

void Estimator::Impl::finish_frame() {
    if (!waiting.is_set) {
        complete_view();
        return;
    }
    waiting.wants_view = true;
    if (waits_at_newest_frame()) {
        const StageScope scope(observer, Stage::kTracking);
        frontend.match_surface(waiting.tracks);
    } else {
        take_waiting();
    }
}

}  // namespace facet
