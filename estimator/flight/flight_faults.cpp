// SPDX-License-Identifier: BSD-2-Clause
// How a frame is compared with the map, and what follows if it contradicts the inertial readings.
#include "estimator/flight/flight.h"
#include "estimator/values/stage_scope.h"

namespace facet {
namespace {

// Nominal periods within which the last reading before a keyframe lies, jitter included.
constexpr double kLastReadings = 1.5;

}  // namespace

Status Flight::compare_with_map(const Preintegration& preintegration, FrameEstimate& out) {
    const StageScope scope(observer_, Stage::kFrameUpdate);
    const FramePrediction prediction{s_.newest.state, preintegration, s_.now.state, s_.newest.covariance,
                                     config_.imu_noise};
    FACET_TRY(frame_update_.solve(map_, window_.cameras(), static_cast<int>(window_.state().keyframes.size()),
                                  prediction, {tracks_.observations.data(), tracks_.observations.size()}, out));
    s_.gauge.note_comparison(s_.newest.stamp);
    return Status::kOk;
}

void Flight::update_by_image(Preintegration& preintegration) {
    FrameEstimate updated;
    if (ok(examine_image(preintegration, updated))) {
        take_over(updated);
    }
}

void Flight::take_over(const FrameEstimate& updated) {
    s_.now.state = updated.state;
    s_.now.covariance = updated.covariance;
    s_.fit = {updated.landmarks, updated.chi2};
}

Status Flight::examine_image(Preintegration& preintegration, FrameEstimate& out) {
    // The map takes the tilt of its keyframes for known: during a start an error of it would be taken for a bias.
    const bool is_starting = monitor_.state() == TrackingState::kInit;
    if (!config_.window.update_frames || is_starting || s_.phase == Phase::kCoasting || map_.empty()) {
        return Status::kNotFound;
    }
    FACET_TRY(compare_with_map(preintegration, out));
    if (waiting_.is_set && calls_for_doubt(out)) {
        take_waiting(preintegration);
        FACET_TRY(compare_with_map(preintegration, out));
    }
    if (monitor_.is_usable() && s_.stereo.is_independent() && calls_for_doubt(out)) {
        doubt_readings(preintegration, out);
    }
    return Status::kOk;
}

bool Flight::calls_for_doubt(const FrameEstimate& usual) const {
    return InertialDoubt::is_called_for(usual, doubt_limits(), (s_.span.stuck & ~s_.doubt.axes()) != 0);
}

void Flight::doubt_readings(Preintegration& preintegration, FrameEstimate& out) {
    InertialDoubt& doubt = s_.doubt;
    const Timestamp stamp = s_.now.stamp;
    const Preintegration as_read = preintegration;
    const ImuAxisMask stuck = s_.span.stuck;
    FrameEstimate free;
    imu_.doubt(s_.newest.stamp, stamp, kGyroAxes | kAccelAxes, doubt.steady(s_.newest.state, gravity_m_per_s2_));
    imu_.set_doubt_noise(InertialDoubt::unlimited(config_.imu_limits));
    const bool is_justified = ok(predict(stamp, preintegration)) && ok(compare_with_map(preintegration, free)) &&
                              InertialDoubt::is_justified(out, free, doubt_limits(), (stuck & ~doubt.axes()) != 0);
    if (is_justified) {
        doubt.begin(s_.newest.state, free.state, as_read, stuck);
        out = free;
    }
    if (doubt.is_active()) {
        imu_.doubt(s_.newest.stamp, stamp, doubt.axes(), doubt.steady(s_.newest.state, gravity_m_per_s2_));
    } else {
        imu_.trust(s_.newest.stamp, stamp);
    }
    if (is_justified && ok(predict(stamp, preintegration))) {
        doubt.measure(s_.newest.state, free.state, preintegration);
    }
    imu_.set_doubt_noise(doubt.noise());
    FrameEstimate again;
    if (ok(predict(stamp, preintegration)) && is_justified && ok(compare_with_map(preintegration, again))) {
        out = again;
    }
}

void Flight::replace_doubted(Timestamp stamp) {
    if (s_.doubt.is_active()) {
        const DoubtedReadings doubted = s_.doubt.readings(s_.now.state, gravity_m_per_s2_);
        imu_.doubt(s_.now.stamp, stamp, doubted.axes, doubted.motion);
        imu_.set_doubt_noise(doubted.noise);
    }
}

void Flight::drop_unsupported_doubt(Preintegration& preintegration) {
    const bool is_judged = s_.doubt.is_active() && s_.phase != Phase::kCoasting;
    s_.stereo.support(s_.doubt.is_active(), is_judged && tracks_.is_keyframe);
    if (!is_judged) {
        return;
    }
    const bool sees = static_cast<int>(tracks_.observations.size()) >= config_.health.few_features;
    if (s_.stereo.is_unmatched() && !s_.stereo.has_supported()) {
        imu_.trust(s_.newest.stamp, s_.now.stamp);
    } else if (!sees && (s_.doubt.axes() & ~s_.span.stuck) != 0) {
        const Preintegration as_replaced = preintegration;
        imu_.show_read(s_.newest.stamp, s_.now.stamp);
        if (ok(predict(s_.now.stamp, preintegration))) {
            imu_.set_doubt_noise(InertialDoubt::noise_between(preintegration, as_replaced));
        }
    } else {
        return;
    }
    s_.doubt.end();
    static_cast<void>(predict(s_.now.stamp, preintegration));
}

void Flight::follow_doubt() {
    const auto& keyframes = window_.state().keyframes;
    const std::size_t n = keyframes.size();
    if (!s_.doubt.is_active() || n < 3 || !keyframes[n - 1].has_imu_factor || !keyframes[n - 2].has_imu_factor) {
        return;
    }
    const std::span<const Keyframe> all(keyframes.data(), n);
    s_.doubt.follow(all.last<3>(), imu_, config_.imu_noise, preintegration_from({}));
    if (!s_.doubt.is_active()) {  // the first step after this keyframe begins with a reading that is believed again
        const Timestamp end = keyframes[n - 1].stamp;
        imu_.trust(end - Duration::from_seconds(kLastReadings / config_.imu_noise.rate_hz), end);
    }
    if (s_.doubt.tilt_rad() > 0.0) {
        s_.restart.add(RestartReason::kTilted);
    }
}

}  // namespace facet
