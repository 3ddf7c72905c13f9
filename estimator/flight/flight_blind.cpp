// SPDX-License-Identifier: BSD-2-Clause
// How a flight goes on without frames, by inertial samples alone, for any time and at any rate of the IMU; and with
// the other camera.
#include "estimator/flight/belief_changes.h"
#include "estimator/flight/flight.h"

namespace facet {

void FlightEstimator::exchange_cameras() {
    take_waiting();
    const RigCalibration corrections = cameras_.exchange(window_.calibration());
    frontend_.swap(other_frontend_);
    frontend_.reset();
    s_.frames.q_Bf_B.setIdentity();
    window_.change_rig(cameras_.rig(), corrections);
    configure_starts();
    forget_corrections();
    if (config_.calibration.estimate_cameras) {
        s_.corrections.right = corrections.right;
        s_.corrections.lens = corrections.lens;
        frontend_.correct_cameras(s_.corrections);
    }
    if (has_window(s_.phase)) {
        s_.phase = Phase::kCoasting;  // until a window begins with the other camera
    }
}

Status FlightEstimator::pass_over(const StereoFrame& frame, Timestamp stamp, FrameUse use, Estimate& estimate) {
    s_.frames.last_image = frame.stamp;
    if (!has_window(s_.phase) || !ok(carry_to(stamp, use, estimate))) {
        report(frame, use, estimate);
    }
    s_.carried.reset();
    return Status::kOk;
}

Eigen::Quaterniond FlightEstimator::turn_since_frame(Timestamp before) {
    Eigen::Quaterniond& q_Bf_B = s_.frames.q_Bf_B;
    Eigen::Quaterniond turn;
    if (!ok(imu_.rotation_between(before, s_.now.stamp, s_.now.state.bias.gyro, turn))) {
        frontend_.reset();
        q_Bf_B.setIdentity();
        return q_Bf_B;
    }
    const bool was_carried = q_Bf_B.coeffs() != Eigen::Quaterniond::Identity().coeffs();
    q_Bf_B = was_carried ? (q_Bf_B * turn).normalized() : turn;
    return q_Bf_B;
}

void FlightEstimator::carry_without_frames() {
    const Timestamp newest = imu_.newest();
    const Timestamp until = s_.frames.carry_until(newest);
    // At high rates the history is short: half of it is kept for frames.
    const bool is_running_out = imu_.size() == kMaxImuSamples && s_.now.stamp < imu_.sample(kMaxImuSamples / 4).stamp;
    Estimate estimate;
    Status carried = Status::kNotReady;
    if (s_.frames.are_missing(newest) && (until - s_.now.stamp).seconds() >= FrameTimes::kCarry_s) {
        carried = carry_to(until, FrameUse::kMissing, estimate);
    } else if (is_running_out) {
        carried = carry_to(imu_.sample(kMaxImuSamples / 2).stamp, FrameUse::kMissing, estimate);
    }
    if (ok(carried)) {
        s_.carried = estimate;
    }
}

Status FlightEstimator::carry_to(Timestamp stamp, FrameUse use, Estimate& estimate) {
    take_waiting();
    const Belief before = s_.now;
    Preintegration preintegration = preintegration_from(before.state.bias);
    FACET_TRY(imu_.integrate_between(before.stamp, stamp, config_.imu_noise, preintegration, &s_.span));
    s_.now.stamp = stamp;
    static_cast<void>(turn_since_frame(before.stamp));
    s_.now.state = preintegration.predict(before.state);
    s_.now.covariance = propagate_covariance(before.state, before.covariance, preintegration, config_.imu_noise);
    // `tracks_` is still that of the last frame.
    update_rest(tracks_.image == ImageState::kUsable && tracks_.is_still);
    if (s_.rest.rests()) {
        hold_blind(before, (s_.now.stamp - s_.frames.last_frame).seconds(), s_.now);
    }
    report({}, use, estimate);
    return Status::kOk;
}

void FlightEstimator::update_rest(bool images_rest) {
    s_.rest.step(images_rest, imu_, s_.now.stamp, {config_.imu_noise, s_.now.state.bias, gravity_m_per_s2_});
}

}  // namespace facet
