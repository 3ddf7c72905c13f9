// SPDX-License-Identifier: BSD-2-Clause
// How a window begins anew: in flight, after a start gone astray, on a new clock.
#include <algorithm>
#include <cmath>

#include "estimator/flight/belief_changes.h"
#include "estimator/flight/flight.h"
#include "estimator/imu/static_init.h"

namespace facet {
namespace {

// A velocity known like this makes a window of one camera metric.
constexpr double kKnownVelocity = 0.25;  // m/s
// What a vehicle may have done in a second of which nothing is known, beyond going on.
constexpr double kManoeuvre_m_per_s2 = 3.0;
constexpr double kTilt_rad_per_s = 0.15;

}  // namespace

void FlightEstimator::begin_window(const StateCovariance& information, CalibrationStart calibration) {
    const KeyframeInput input = keyframe_input();
    window_.start(input, s_.now.state, information, calibration);
    waiting_.is_set = false;
    s_.keyframe = {{}, s_.keyframe.is_new, false};
    s_.fault.end();
    if (calibration == CalibrationStart::kAsGiven) {
        forget_corrections();
    }
    s_.phase = Phase::kFollowing;
    s_.now.imu_scale = window_.calibration().imu;
    s_.newest = s_.now;
    map_.clear();
    const bool has_velocity =
        s_.now.covariance.diagonal().segment<3>(kVel).maxCoeff() < kKnownVelocity * kKnownVelocity ||
        tracks_.stereo >= kStereoStart;
    const bool has_answer = motion_start_.ends_at(s_.now.stamp);
    s_.start.begin_window(s_.now.stamp, has_velocity, has_answer);
    if (!has_answer) {  // else the window begins from its answer, which later keyframes test
        motion_start_.reset();
        motion_start_.add_keyframe(s_.now.stamp, input.observations, imu_, s_.now);
    }
}

void FlightEstimator::begin_window_in_place_of(const Belief& before) {
    keep_place(s_.trusted && is_finite(before) ? &before : nullptr, s_.now);
    fix_gauge();
    begin_window(inverse(s_.now.covariance), calibration_start());
}

void FlightEstimator::begin_window_at(const NavState& state, const StateCovariance& covariance) {
    const Belief before = s_.now;
    s_.now.state = state;
    s_.now.covariance = covariance;
    begin_window_in_place_of(before);
}

void FlightEstimator::fix_gauge() {
    if (s_.trusted) {
        s_.gauge.absorb(s_.now);
    }
    fix_place(s_.now);
}

void FlightEstimator::restart_in_motion() {
    InitialState initial;
    if (!ok(initialize_state(imu_, s_.now.stamp, gravity_m_per_s2_, config_.initializer, initial, false))) {
        return;
    }
    begin_window_at(initial.state, inverse(initial.information()));
    s_.rest.end();
    s_.restart_requested = false;
    s_.start.drop_claim();
    s_.resets.jump();
    monitor_.restart(s_.now.stamp, false);
}

void FlightEstimator::restart_in_flight() {
    inflate_covariance();
    const bool is_worthless =
        monitor_.has_diverged() || !is_finite(s_.now) || tilt_sigma(s_.now) > kWorthlessTiltSigma_rad;
    if (is_worthless && !ok(fall_back_to_gravity())) {
        return;
    }
    // Keeps the covariance from becoming singular by rounding.
    s_.now.covariance = (0.5 * (s_.now.covariance + s_.now.covariance.transpose())).eval();
    s_.now.covariance.diagonal().array() += 1e-10;
    fix_gauge();
    s_.rest.end();
    s_.restart_requested = false;
    s_.start.renew();
    const bool keeps_place = s_.keeps_place && !is_worthless;
    s_.keeps_place = false;
    if (!keeps_place) {
        s_.resets.jump();
    }
    // What has led the state astray may have led the calibration astray.
    begin_window(inverse(s_.now.covariance), is_worthless ? CalibrationStart::kAsGiven : CalibrationStart::kAsKnown);
    monitor_.restart(s_.now.stamp, keeps_place);
}

void FlightEstimator::inflate_covariance() {
    const double lost_s = std::min(s_.clocks.take_lost_s(), 1.0);
    const double tilt_rad = kTilt_rad_per_s * lost_s;
    const Eigen::Matrix3d R_B_W = s_.now.state.q_W_B.conjugate().toRotationMatrix();
    const Eigen::Vector3d variance = tilt_rad * tilt_rad * Eigen::Vector3d(1.0, 1.0, 0.0);
    s_.now.covariance.block<3, 3>(kTheta, kTheta) += R_B_W * variance.asDiagonal() * R_B_W.transpose();
    s_.now.covariance.diagonal().segment<3>(kVel).array() += std::pow(kManoeuvre_m_per_s2 * lost_s, 2);
}

Status FlightEstimator::fall_back_to_gravity() {
    InitialState initial;
    FACET_TRY(initialize_state(imu_, s_.now.stamp, gravity_m_per_s2_, config_.initializer, initial));
    const bool is_worth_keeping = is_finite(s_.now) && !monitor_.has_diverged();
    const Belief kept = is_worth_keeping ? s_.now : salvage(s_.trusted.value_or(Belief{}), s_.now);
    fall_back(initial.state, kept, config_.initializer.gyro_bias_sigma_rad_per_s,
              config_.initializer.accel_bias_sigma_m_per_s2, s_.now);
    return Status::kOk;
}

void FlightEstimator::begin_on_new_clock() {
    // By the cameras' clock, if that has gone on.
    const double lost_s = s_.clocks.time_on_new_clock_s(s_.trusted.value_or(Belief{}).stamp);
    const Timestamp offered = s_.clocks.offered();
    begin_like_first(lost_s);
    if (s_.trusted) {
        s_.trusted->stamp = offered;
    }
    imu_.restart();
    ranges_.clear();
}

void FlightEstimator::move_images(double off_s) {
    ImuSample sample;
    if (!ok(imu_.interpolate(s_.now.stamp, sample))) {
        begin_like_first(std::abs(off_s));
        return;
    }
    Belief& now = s_.now;
    const Eigen::Vector3d w_B = sample.w_B - now.state.bias.gyro;
    const Eigen::Vector3d a_W =
        now.state.q_W_B * (sample.a_B - now.state.bias.accel) - gravity_m_per_s2_ * Eigen::Vector3d::UnitZ();
    const auto widen = [&](int at, double size) { now.covariance.diagonal().segment<3>(at).array() += size * size; };
    widen(kTheta, w_B.norm() * off_s);
    widen(kPos, now.state.v_W_B.norm() * off_s);
    widen(kVel, a_W.norm() * off_s);
    widen_biases(config_.initializer.gyro_bias_sigma_rad_per_s, config_.initializer.accel_bias_sigma_m_per_s2, now);
    imu_.restore(imu_.oldest(), imu_.newest());
    s_.frames.last_frame = now.stamp;  // up to there estimates have been given
    now.stamp = now.stamp + Duration::from_seconds(off_s);
    leave_window();
    s_.keeps_place = true;
}

void FlightEstimator::leave_window() {
    s_.now.replaced = {};
    s_.fault = {};
    s_.span = {};
    s_.fit = {};
    map_.clear();
    waiting_.is_set = false;
    s_.rest.end();
    s_.start.drop_claim();
    s_.phase = Phase::kCoasting;
}

void FlightEstimator::begin_like_first(double lost_s) {
    if (s_.trusted) {
        widen_after_unknown(s_.fault.rate_B(), lost_s, *s_.trusted);
        // A sensor that has begun anew may have other biases; after a wrong delay they are wrong, too.
        widen_biases(config_.initializer.gyro_bias_sigma_rad_per_s, config_.initializer.accel_bias_sigma_m_per_s2,
                     *s_.trusted);
    }
    frontend_.reset();
    tracks_ = {};
    map_.clear();
    waiting_.is_set = false;
    monitor_.reset();
    cameras_.forget_frames();
    s_.phase = Phase::kEmpty;
    s_.span = {};
    s_.keyframe.summary = {};
    s_.start.drop_claim();
    s_.rest.end();
    s_.fault = {};
    s_.clocks.forget_refused();
    s_.frames.q_Bf_B.setIdentity();
    s_.restart_requested = false;
    s_.carried.reset();
}

}  // namespace facet
