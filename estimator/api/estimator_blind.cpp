// SPDX-License-Identifier: BSD-2-Clause
// How the estimator goes on without frames: by inertial samples alone, for any time and at any rate of the IMU.
#include <algorithm>
#include <cmath>

#include "estimator/api/estimator_impl.h"
#include "estimator/factors/rest_factor.h"

namespace facet {
namespace {

// Frames that have not come for this long are missing: five periods of a camera at 10 Hz.
constexpr double kMissing_s = 0.5;
// Between two estimates without frames.
constexpr double kCarry_s = 0.1;
// Inertial samples younger than this may belong before a frame on its way; it grows if one is later, up to a second.
constexpr Duration kUsualLatency = Duration::from_seconds(0.2);
constexpr Duration kLongestLatency = Duration::from_seconds(1.0);
// What a vehicle that seems to stand may creep without its IMU noticing (estimator/imu/stationarity.h).
constexpr double kCreep_m_per_s = 0.01;
constexpr double kCreep_rad_per_s = 5e-4;

}  // namespace

Eigen::Quaterniond Estimator::Impl::turn_since_frame(Timestamp before) {
    Eigen::Quaterniond turn;
    if (!ok(imu.rotation_between(before, now.stamp, now.state.bias.gyro, turn))) {
        frontend.reset();
        q_Bf_B.setIdentity();
        return q_Bf_B;
    }
    const bool was_carried = q_Bf_B.coeffs() != Eigen::Quaterniond::Identity().coeffs();
    q_Bf_B = was_carried ? (q_Bf_B * turn).normalized() : turn;
    return q_Bf_B;
}

void Estimator::Impl::expect_late_frames(Timestamp image, Timestamp stamp) {
    if (image > last_image && has_window(phase) && stamp > last_frame && imu.newest() > stamp) {
        const Duration late = imu.newest() - stamp + Duration::from_seconds(kCarry_s);
        frame_latency = std::clamp(late, frame_latency, kLongestLatency);
    }
}

void Estimator::Impl::carry_without_frames() {
    if (!has_window(phase)) {
        return;
    }
    const Timestamp newest_sample = imu.newest();
    const Timestamp until = newest_sample - std::max(frame_latency, kUsualLatency);
    const bool is_missing =
        (newest_sample - last_frame).seconds() > kMissing_s && (until - now.stamp).seconds() >= kCarry_s;
    // At high rates the history is short: half of it is kept for frames.
    const bool is_running_out = imu.size() == kMaxImuSamples && now.stamp < imu.sample(kMaxImuSamples / 4).stamp;
    if (is_missing) {
        carry_to(until);
    } else if (is_running_out) {
        carry_to(imu.sample(kMaxImuSamples / 2).stamp);
    }
}

void Estimator::Impl::carry_to(Timestamp stamp) {
    take_waiting();
    const Belief before = now;
    Preintegration preintegration = preintegration_from(now.state.bias);
    if (!ok(imu.integrate_between(now.stamp, stamp, config.imu_noise, preintegration, &span))) {
        return;
    }
    now.stamp = stamp;
    static_cast<void>(turn_since_frame(before.stamp));
    now.state = preintegration.predict(before.state);
    now.covariance = propagate_covariance(before.state, before.covariance, preintegration, config.imu_noise);
    // `tracks` is still that of the last frame.
    judge_rest(tracks.image == ImageState::kUsable && tracks.is_still);
    if (rests) {
        stand_blind(before);
    }
    is_blind = true;
    report({}, false, carried);
    is_blind = false;
    has_carried = true;
}

void Estimator::Impl::stand_blind(const Belief& before) {
    const double dt_s = (now.stamp - before.stamp).seconds();
    const double time_s = (now.stamp - last_frame).seconds();
    const RestSigmas sigmas;
    // Sums of steps that are all wrong in the same direction: the deviation grows with time, not with its root.
    const auto growth = [&](double rate) { return rate * rate * dt_s * (2.0 * time_s - dt_s); };
    now.state.q_W_B = before.state.q_W_B;
    now.state.p_W_B = before.state.p_W_B;
    now.state.v_W_B.setZero();
    StateCovariance& c = now.covariance;
    c = before.covariance;
    c.middleRows<3>(kVel).setZero();
    c.middleCols<3>(kVel).setZero();
    const double v_variance = sigmas.v_m_per_s * sigmas.v_m_per_s + kCreep_m_per_s * kCreep_m_per_s;
    c.diagonal().segment<3>(kVel).setConstant(v_variance);
    c.diagonal().segment<3>(kPos).array() += growth(kCreep_m_per_s);
    const Eigen::Vector3d up_B = now.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    c.block<3, 3>(kTheta, kTheta) += growth(kCreep_rad_per_s) * up_B * up_B.transpose();
}

}  // namespace facet
