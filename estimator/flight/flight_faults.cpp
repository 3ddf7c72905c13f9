// SPDX-License-Identifier: BSD-2-Clause
// How a frame is compared with the map, and what follows if it contradicts the inertial readings.
#include "estimator/flight/belief_changes.h"
#include "estimator/flight/flight.h"
#include "estimator/values/stage_scope.h"

namespace facet {
namespace {

// Nominal periods within which the last reading before a keyframe lies, jitter included.
constexpr double kLastReadings = 1.5;
// A vehicle that sets out with an emitter on is contradicted within this time (0.15 to 0.25 s in rendered rooms).
constexpr double kDotsBelieved_s = 0.5;

}  // namespace

Status FlightEstimator::compare_with_map(const Preintegration& preintegration, FrameEstimate& out) {
    const StageScope scope(observer_, Stage::kFrameUpdate);
    const FramePrediction prediction{s_.newest.state, preintegration, s_.now.state, s_.newest.covariance,
                                     config_.imu_noise};
    FACET_TRY(frame_update_.solve(map_, window_.cameras(), static_cast<int>(window_.state().keyframes.size()),
                                  prediction, {tracks_.observations.data(), tracks_.observations.size()}, out));
    s_.gauge.note_comparison(s_.newest.stamp);
    return Status::kOk;
}

void FlightEstimator::update_by_image(Preintegration& preintegration) {
    FrameEstimate updated;
    if (ok(examine_image(preintegration, updated))) {
        take_over(updated);
    }
}

void FlightEstimator::take_over(const FrameEstimate& updated) {
    s_.now.state = updated.state;
    s_.now.covariance = updated.covariance;
    s_.fit = {updated.landmarks, updated.chi2};
}

Status FlightEstimator::examine_image(Preintegration& preintegration, FrameEstimate& out) {
    // The map takes the tilt of its keyframes for known: during a start an error of it would be taken for a bias.
    const bool is_starting = monitor_.state() == TrackingState::kInit;
    if (is_starting || s_.phase == Phase::kCoasting || map_.empty()) {
        return Status::kNotFound;
    }
    FACET_TRY(compare_with_map(preintegration, out));
    if (waiting_.is_set && suggests_fault(out)) {
        take_waiting(preintegration);
        FACET_TRY(compare_with_map(preintegration, out));
    }
    if (monitor_.is_usable() && s_.stereo.is_independent() && suggests_fault(out)) {
        isolate_fault(preintegration, out);
    }
    return Status::kOk;
}

bool FlightEstimator::suggests_fault(const FrameEstimate& usual) const {
    return InertialFault::is_called_for(usual, fault_limits(), (s_.span.stuck & ~s_.fault.axes()) != 0);
}

void FlightEstimator::isolate_fault(Preintegration& preintegration, FrameEstimate& out) {
    InertialFault& fault = s_.fault;
    const Timestamp stamp = s_.now.stamp;
    const Preintegration as_read = preintegration;
    const ImuAxisMask stuck = s_.span.stuck;
    FrameEstimate free;
    imu_.replace(s_.newest.stamp, stamp, kGyroAxes | kAccelAxes, fault.steady(s_.newest.state, gravity_m_per_s2_));
    imu_.set_replacement_noise(InertialFault::unlimited(config_.imu_limits));
    const bool is_justified = ok(predict(stamp, preintegration)) && ok(compare_with_map(preintegration, free)) &&
                              InertialFault::is_justified(out, free, fault_limits(), (stuck & ~fault.axes()) != 0);
    if (is_justified) {
        s_.unsuspecting = fault.is_active() ? s_.unsuspecting : s_.newest;
        fault.begin(s_.newest.state, free.state, as_read, stuck);
        out = free;
    }
    if (fault.is_active()) {
        imu_.replace(s_.newest.stamp, stamp, fault.axes(), fault.steady(s_.newest.state, gravity_m_per_s2_));
    } else {
        imu_.restore(s_.newest.stamp, stamp);
    }
    if (is_justified && ok(predict(stamp, preintegration))) {
        fault.measure(s_.newest.state, free.state, preintegration);
    }
    imu_.set_replacement_noise(fault.noise());
    FrameEstimate again;
    if (ok(predict(stamp, preintegration)) && is_justified && ok(compare_with_map(preintegration, again))) {
        out = again;
    }
}

void FlightEstimator::take_out_dots(Preintegration& preintegration) {
    frontend_.take_out_dots();
    other_frontend_.take_out_dots();
    tracks_ = {};
    tracks_.stamp = s_.now.stamp;
    if (s_.fault.is_active()) {
        imu_.restore(imu_.oldest(), imu_.newest());
        s_.fault.end();
        s_.newest = s_.unsuspecting;
        static_cast<void>(predict(s_.now.stamp, preintegration));
    }
    leave_window();
    window_.forget_calibration();
    forget_corrections();
    // What the dots have made of the state before anything contradicted them.
    s_.clocks.lose(kDotsBelieved_s);
    widen_biases(config_.initializer.gyro_bias_sigma_rad_per_s, config_.initializer.accel_bias_sigma_m_per_s2, s_.now);
}

void FlightEstimator::replace_readings(Timestamp stamp) {
    if (s_.fault.is_active()) {
        const ReplacedReadings replaced = s_.fault.readings(s_.now.state, gravity_m_per_s2_);
        imu_.replace(s_.now.stamp, stamp, replaced.axes, replaced.motion);
        imu_.set_replacement_noise(replaced.noise);
    }
}

void FlightEstimator::drop_unsupported_fault(Preintegration& preintegration) {
    const bool is_judged = s_.fault.is_active() && s_.phase != Phase::kCoasting;
    s_.stereo.support(s_.fault.is_active(), is_judged && tracks_.is_keyframe);
    if (!is_judged) {
        return;
    }
    const bool sees = static_cast<int>(tracks_.observations.size()) >= HealthConfig::kFewFeatures;
    if (s_.stereo.is_unmatched() && !s_.stereo.has_supported()) {
        imu_.restore(s_.newest.stamp, s_.now.stamp);
    } else if (!sees && (s_.fault.axes() & ~s_.span.stuck) != 0) {
        const Preintegration as_replaced = preintegration;
        imu_.show_as_read(s_.newest.stamp, s_.now.stamp);
        if (ok(predict(s_.now.stamp, preintegration))) {
            imu_.set_replacement_noise(InertialFault::noise_between(preintegration, as_replaced));
        }
    } else {
        return;
    }
    s_.fault.end();
    static_cast<void>(predict(s_.now.stamp, preintegration));
}

void FlightEstimator::follow_fault() {
    const auto& keyframes = window_.state().keyframes;
    const std::size_t n = keyframes.size();
    if (!s_.fault.is_active() || n < 3 || !keyframes[n - 1].has_imu_factor || !keyframes[n - 2].has_imu_factor) {
        return;
    }
    const std::span<const Keyframe> all(keyframes.data(), n);
    s_.fault.follow(all.last<3>(), imu_, config_.imu_noise, preintegration_from({}));
    if (!s_.fault.is_active()) {  // the first step after this keyframe begins with a reading that is believed again
        const Timestamp end = keyframes[n - 1].stamp;
        imu_.restore(end - Duration::from_seconds(kLastReadings / config_.imu_noise.rate_hz), end);
    }
}

}  // namespace facet
