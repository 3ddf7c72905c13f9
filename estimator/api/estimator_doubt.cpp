// SPDX-License-Identifier: BSD-2-Clause
// How a frame is compared with the map, and what follows if it contradicts the inertial readings.
#include <algorithm>
#include <cmath>

#include "estimator/api/estimator_impl.h"
#include "estimator/window/stage_scope.h"

namespace facet {
namespace {

// What a vehicle may have done in a second of which nothing is known, beyond going on.
constexpr double kManoeuvre_m_per_s2 = 3.0;
constexpr double kTilt_rad_per_s = 0.15;
// Of what images correct in the place after an outage, as much is wrong still: the velocity at its end tells what grew
// like its integral. Flights of real drones and simulated ones with vibration: 0.1 to 0.45, 6 to 8 s.
constexpr double kLeapShare = 0.3;
// Nominal periods within which the last reading before a keyframe lies, jitter included.
constexpr double kLastReadings = 1.5;

}  // namespace

Status Estimator::Impl::compare_with_map(const Preintegration& preintegration, FrameEstimate& out) {
    const StageScope scope(observer, Stage::kFrameUpdate);
    const FramePrediction prediction{newest.state, preintegration, now.state, newest.covariance, config.imu_noise};
    FACET_TRY(frame_update.solve(map, window.cameras(), static_cast<int>(window.state().keyframes.size()), prediction,
                                 {tracks.observations.data(), tracks.observations.size()}, out));
    is_compared = true;
    compared_with = newest.stamp;
    return Status::kOk;
}

void Estimator::Impl::update_by_image(Preintegration& preintegration) {
    FrameEstimate updated;
    if (ok(examine_image(preintegration, updated))) {
        take_over(updated);
    }
}

void Estimator::Impl::take_over(const FrameEstimate& updated) {
    now.state = updated.state;
    now.covariance = updated.covariance;
    map_landmarks = updated.landmarks;
    frame_chi2 = updated.chi2;
}

Status Estimator::Impl::examine_image(Preintegration& preintegration, FrameEstimate& out) {
    // The map takes the tilt of its keyframes for known: during a start an error of it would be taken for a bias.
    const bool is_starting = monitor.state() == TrackingState::kInit;
    if (!config.window.update_frames || is_starting || phase == Phase::kCoasting || map.empty()) {
        return Status::kNotFound;
    }
    FACET_TRY(compare_with_map(preintegration, out));
    if (waiting.is_set && calls_for_doubt(out)) {
        take_waiting(preintegration);
        FACET_TRY(compare_with_map(preintegration, out));
    }
    if (monitor.is_usable() && may_accuse && calls_for_doubt(out)) {
        doubt_readings(preintegration, out);
    }
    return Status::kOk;
}

bool Estimator::Impl::calls_for_doubt(const FrameEstimate& usual) const {
    return InertialDoubt::is_called_for(usual, doubt_limits(), (span.stuck & ~doubt.axes()) != 0);
}

void Estimator::Impl::doubt_readings(Preintegration& preintegration, FrameEstimate& out) {
    const Timestamp stamp = now.stamp;
    const Preintegration as_read = preintegration;
    const ImuAxisMask stuck = span.stuck;
    FrameEstimate free;
    imu.doubt(newest.stamp, stamp, kGyroAxes | kAccelAxes, doubt.steady(newest.state, gravity_m_per_s2));
    imu.set_doubt_noise(InertialDoubt::unlimited(config.imu_limits));
    const bool is_justified = ok(predict(stamp, preintegration)) && ok(compare_with_map(preintegration, free)) &&
                              InertialDoubt::is_justified(out, free, doubt_limits(), (stuck & ~doubt.axes()) != 0);
    if (is_justified) {
        doubt.begin(newest.state, free.state, as_read, stuck);
        out = free;
    }
    if (doubt.is_active()) {
        imu.doubt(newest.stamp, stamp, doubt.axes(), doubt.steady(newest.state, gravity_m_per_s2));
    } else {
        imu.trust(newest.stamp, stamp);
    }
    if (is_justified && ok(predict(stamp, preintegration))) {
        doubt.measure(newest.state, free.state, preintegration);
    }
    imu.set_doubt_noise(doubt.noise());
    FrameEstimate again;
    if (ok(predict(stamp, preintegration)) && is_justified && ok(compare_with_map(preintegration, again))) {
        out = again;
    }
}

void Estimator::Impl::replace_doubted(Timestamp stamp) {
    if (doubt.is_active()) {
        const DoubtedReadings doubted = doubt.readings(now.state, gravity_m_per_s2);
        imu.doubt(now.stamp, stamp, doubted.axes, doubted.motion);
        imu.set_doubt_noise(doubted.noise);
    }
}

void Estimator::Impl::judge_witness() {
    const bool was_unmatched = is_unmatched;
    if (tracks.is_keyframe) {
        is_unmatched = tracks.stereo < HealthMonitor::kFewStereo;
    }
    may_accuse = !was_unmatched && !is_unmatched;
}

void Estimator::Impl::drop_doubt_without_witness(Preintegration& preintegration) {
    if (!doubt.is_active() || phase == Phase::kCoasting) {
        is_witnessed = is_witnessed && doubt.is_active();
        return;
    }
    is_witnessed = is_witnessed || (tracks.is_keyframe && may_accuse);
    const bool sees = static_cast<int>(tracks.observations.size()) >= config.health.few_features;
    if (is_unmatched && !is_witnessed) {
        imu.trust(newest.stamp, now.stamp);
    } else if (!sees && (doubt.axes() & ~span.stuck) != 0) {
        const Preintegration as_replaced = preintegration;
        imu.show_read(newest.stamp, now.stamp);
        if (ok(predict(now.stamp, preintegration))) {
            imu.set_doubt_noise(InertialDoubt::noise_between(preintegration, as_replaced));
        }
    } else {
        return;
    }
    doubt.end();
    static_cast<void>(predict(now.stamp, preintegration));
}

void Estimator::Impl::widen_gauge(double dt_s) {
    slip.is_refutable = false;
    gauge = gauge.about(now.state.p_W_B);
    const Eigen::Vector3d& v = now.state.v_W_B;
    const auto widen = [&c = gauge.covariance](int i, double by) { c(i, i) = std::pow(std::sqrt(c(i, i)) + by, 2); };
    widen(0, std::abs((now.state.q_W_B * doubt.rate_B()).z()) * dt_s);
    for (int i = 0; i < 3; ++i) {
        widen(1 + i, v.norm() * dt_s);
    }
}

bool Estimator::Impl::judge_slip(double dt_s, bool are_residuals_high) {
    if (are_residuals_high) {
        Slip seen = slip.is_suspected ? slip : Slip{true, true, compared_with, gauge};
        const bool is_alone = is_compared && compared_with == seen.keyframe && !tracks.is_keyframe;
        seen.is_refutable = seen.is_refutable && is_alone;
        widen_gauge(dt_s);
        slip = seen;
        return true;
    }
    const bool is_refuted = slip.is_refutable && is_compared && compared_with == slip.keyframe;
    if (is_refuted) {
        gauge = slip.gauge;
    }
    slip = {};
    return is_refuted;
}

void Estimator::Impl::own_up() {
    const double lost_s = std::min(lost_time_s, 1.0);
    // A tilt hides as a bias of the accelerometer.
    const double bend_rad = is_bent ? (now.state.bias.accel - bias_before.accel).norm() / gravity_m_per_s2 : 0.0;
    const double tilt_rad = std::hypot(doubt.tilt_rad(), kTilt_rad_per_s * lost_s, bend_rad);
    const Eigen::Matrix3d R_B_W = now.state.q_W_B.conjugate().toRotationMatrix();
    const Eigen::Vector3d variance = tilt_rad * tilt_rad * Eigen::Vector3d(1.0, 1.0, 0.0);
    now.covariance.block<3, 3>(kTheta, kTheta) += R_B_W * variance.asDiagonal() * R_B_W.transpose();
    now.covariance.diagonal().segment<3>(kVel).array() += std::pow(kManoeuvre_m_per_s2 * lost_s, 2);
    lost_time_s = 0.0;
    if (is_bent) {
        now.state.bias = bias_before;
        now.covariance.diagonal().segment<3>(kBiasGyro).array() +=
            std::pow(config.initializer.gyro_bias_sigma_rad_per_s, 2);
        now.covariance.diagonal().segment<3>(kBiasAccel).array() +=
            std::pow(config.initializer.accel_bias_sigma_m_per_s2, 2);
    }
}

void Estimator::Impl::own_up_to_leap() {
    slip = {};  // the gauge of before is not to come back
    gauge = gauge.about(now.state.p_W_B);
    gauge.covariance.bottomRightCorner<3, 3>() += kLeapShare * kLeapShare * leap_W * leap_W.transpose();
}

void Estimator::Impl::judge_bend() {
    constexpr int kStraight = 2;
    if (doubt.is_active()) {
        return;
    }
    if (monitor.is_usable() && summary.imu_squared_error > config.health.high_vision_chi2 * kStateDim) {
        bias_before = is_bent ? bias_before : newest.state.bias;
        is_bent = true;
        straight_keyframes = 0;
    } else if (is_bent && ++straight_keyframes == kStraight) {
        reset_wanted = true;
    }
}

void Estimator::Impl::follow_doubt() {
    const auto& keyframes = window.state().keyframes;
    const std::size_t n = keyframes.size();
    if (!doubt.is_active() || n < 3 || !keyframes[n - 1].has_imu_factor || !keyframes[n - 2].has_imu_factor) {
        return;
    }
    const std::span<const Keyframe> all(keyframes.data(), n);
    doubt.follow(all.last<3>(), imu, config.imu_noise, preintegration_from({}));
    if (!doubt.is_active()) {  // the first step after this keyframe begins with a reading that is believed again
        const Timestamp end = keyframes[n - 1].stamp;
        imu.trust(end - Duration::from_seconds(kLastReadings / config.imu_noise.rate_hz), end);
    }
    reset_wanted = reset_wanted || doubt.tilt_rad() > 0.0;
}

}  // namespace facet
