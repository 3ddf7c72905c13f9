// SPDX-License-Identifier: BSD-2-Clause
// How the estimator begins a window: at the start, after a second opinion on the start, and anew in flight.
#include <algorithm>
#include <cmath>

#include "estimator/api/estimator_impl.h"
#include "estimator/imu/static_init.h"

namespace facet {
namespace {

// After divergence only the direction of gravity, position and yaw are kept, at least as uncertain as this:
constexpr double kDivergedTiltSigma = 0.2;      // rad
constexpr double kDivergedVelocitySigma = 2.0;  // m/s
constexpr double kDivergedPositionSigma = 1.0;  // m
constexpr double kDivergedYawSigma = 0.2;       // rad
// With one camera: a velocity known like this makes a window metric; if its closed form has not been confirmed for this
// long, the window has gone astray.
constexpr double kKnownVelocity = 0.25;  // m/s
constexpr double kFruitless_s = 2.0;
constexpr int kStereoStart = 8;
// A vehicle that rotors shake stands if its images do for this long; then keyframes come as fast as at any start until
// so many of them know what the shaking has made of the velocity.
constexpr double kShakenRest_s = 0.3;
constexpr double kStampSlack_s = 1e-3;
constexpr int kHastenedAtRest = 4;
constexpr int kStandingTracks = 8;        // the median of fewer says nothing
constexpr double kOriginSigma = 1e-4;     // m, rad: a choice, not an estimate
constexpr double kUnknownYawSigma = 1.8;  // rad: that of any direction

StateCovariance inverse(const StateCovariance& covariance) {
    return covariance.llt().solve(StateCovariance::Identity());
}

}  // namespace

void Estimator::Impl::begin_window(const StateCovariance& information, CalibrationStart calibration) {
    window.start(keyframe_input(), now.state, information, calibration);
    waiting.is_set = false;
    view_is_open = false;
    doubt.end();
    is_bent = false;
    straight_keyframes = 0;
    if (calibration == CalibrationStart::kAsGiven) {
        forget_corrections();
    }
    phase = Phase::kFollowing;
    now.imu_scale = window.calibration().imu;
    newest = now;
    map.clear();
    summary = {};
    window_began = now.stamp;
    is_confirmed = now.covariance.diagonal().segment<3>(kVel).maxCoeff() < kKnownVelocity * kKnownVelocity ||
                   tracks.stereo >= kStereoStart;
    awaits_answer = !is_confirmed && !monocular_start.ends_at(now.stamp);
    motion_start.reset();
    motion_start.add_keyframe(now.stamp, keyframe_input().observations, imu);
    if (!monocular_start.ends_at(now.stamp)) {  // else the window begins from its answer, which later keyframes test
        monocular_start.reset();
        monocular_start.add_keyframe(now.stamp, keyframe_input().observations, imu, now.state.bias);
    }
}

void Estimator::Impl::begin_window_in_place_of(const Belief& before) {
    keep_place(before);
    fix_gauge();
    begin_window(inverse(now.covariance), calibration_start());
}

void Estimator::Impl::second_opinion() {
    NavState better;
    StateCovariance information;
    const bool is_monocular = tracks.stereo < kStereoStart;
    const Status status = is_monocular ? monocular_start.check(now.state, better, information)
                                       : motion_start.check(now.state, better, information);
    is_confirmed = is_confirmed || !is_monocular || status == Status::kNotFound;
    const Belief before = now;
    if (ok(status)) {
        now.state = better;
        now.covariance = information.inverse();
        begin_window_in_place_of(before);
    } else if (!is_confirmed && (now.stamp - window_began).seconds() > kFruitless_s && ok(fall_back_to_gravity())) {
        monocular_start.reset();
        begin_window_in_place_of(before);
    }
}

void Estimator::Impl::keep_place(const Belief& before) {
    const bool is_known = has_trusted && is_finite(before);
    const auto yaw_variance = [](const Belief& b) {
        const Eigen::Matrix3d R = b.state.q_W_B.toRotationMatrix();
        return (R * b.covariance.block<3, 3>(kTheta, kTheta) * R.transpose())(2, 2);
    };
    if (is_known) {
        turn_to_yaw_of(before.state.q_W_B, now);
    }
    StateCovariance& c = now.covariance;
    const Eigen::Matrix3d R_W_B = now.state.q_W_B.toRotationMatrix();
    Eigen::Matrix3d theta_W = R_W_B * c.block<3, 3>(kTheta, kTheta) * R_W_B.transpose();
    theta_W.row(2).setZero();
    theta_W.col(2).setZero();
    theta_W(2, 2) =
        is_known ? std::min(yaw_variance(before), kUnknownYawSigma * kUnknownYawSigma) : kOriginSigma * kOriginSigma;
    c.block<3, 3>(kTheta, kTheta) = R_W_B.transpose() * theta_W * R_W_B;
    if (is_known) {
        now.state.p_W_B = before.state.p_W_B;
    }
    c.middleRows<3>(kPos).setZero();
    c.middleCols<3>(kPos).setZero();
    c.block<3, 3>(kPos, kPos) = kOriginSigma * kOriginSigma * Eigen::Matrix3d::Identity();
    if (is_known) {
        c.block<3, 3>(kPos, kPos) += before.covariance.block<3, 3>(kPos, kPos);
    }
}

void Estimator::Impl::fix_gauge() {
    StateCovariance& c = now.covariance;
    const Eigen::Matrix3d R_W_B = now.state.q_W_B.toRotationMatrix();
    if (has_trusted) {
        gauge.add(gauge_of(now));
        drift.add(gauge_of(now));
    }
    // Yaw turns with the body: its share of the other parameters' covariance goes with it.
    const StateCovariance before = c;
    Eigen::Matrix3d level = R_W_B.transpose() * Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal() * R_W_B;
    c.middleRows<3>(kTheta) = (level * before.middleRows<3>(kTheta)).eval();
    c.middleCols<3>(kTheta) = (c.middleCols<3>(kTheta) * level.transpose()).eval();
    c.middleRows<3>(kPos).setZero();
    c.middleCols<3>(kPos).setZero();
    const Eigen::Vector3d up_B = R_W_B.transpose() * Eigen::Vector3d::UnitZ();
    c.block<3, 3>(kTheta, kTheta) += kOriginSigma * kOriginSigma * up_B * up_B.transpose();
    c.diagonal().segment<3>(kPos).array() += kOriginSigma * kOriginSigma;
}

void Estimator::Impl::collect_alone() {
    if (tracks.stereo >= kStereoStart) {  // the other camera is back
        monocular_start.reset();
        begin_window(inverse(now.covariance), calibration_start());
        return;
    }
    monocular_start.add_keyframe(now.stamp, keyframe_input().observations, imu, now.state.bias);
    NavState solved;
    StateCovariance information;
    const Belief before = now;
    if (ok(monocular_start.solve(now.state, solved, information))) {
        now.state = solved;
        now.covariance = information.inverse();
        begin_window_in_place_of(before);
    } else if (ok(fall_back_to_gravity())) {
        begin_window_in_place_of(before);
        awaits_answer = true;
    }
}

Belief Estimator::Impl::salvage() const {
    if (is_finite(now) && !monitor.has_diverged()) {
        return now;
    }
    // What was believed since is wrong by an unknown amount: the vehicle is where it was, give or take what it may have
    // flown since. The yaw is the gyroscope's, which is rarely at fault.
    Belief belief = trusted;
    const double time_s = (now.stamp - trusted.stamp).seconds();
    const double flown_m = (trusted.state.v_W_B.norm() + kDivergedVelocitySigma) * time_s;
    if (!is_finite(belief)) {
        belief = {};
    }
    belief.covariance.diagonal().segment<3>(kPos).array() += flown_m * flown_m;
    if (now.state.q_W_B.coeffs().allFinite()) {
        belief.state.q_W_B = now.state.q_W_B;
        const Eigen::Matrix3d carried = now.covariance.block<3, 3>(kTheta, kTheta);
        belief.covariance.block<3, 3>(kTheta, kTheta) =
            carried.allFinite() ? carried
                                : Eigen::Matrix3d(std::pow(kUnknownYawSigma, 2) * Eigen::Matrix3d::Identity());
    }
    return belief;
}

Status Estimator::Impl::fall_back_to_gravity() {
    InitialState initial;
    FACET_TRY(initialize_state(imu, now.stamp, gravity_m_per_s2, config.initializer, initial));
    const Belief kept = salvage();
    const Eigen::Vector3d up_B = initial.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond::FromTwoVectors(kept.state.q_W_B * up_B, Eigen::Vector3d::UnitZ());
    now.state = initial.state;
    now.state.q_W_B = (turn * kept.state.q_W_B).normalized();
    now.state.p_W_B = kept.state.p_W_B;
    const Eigen::Matrix3d R = now.state.q_W_B.toRotationMatrix();
    const Eigen::Matrix3d kept_R = kept.state.q_W_B.toRotationMatrix();
    const double yaw_variance = (kept_R * kept.covariance.block<3, 3>(kTheta, kTheta) * kept_R.transpose())(2, 2) +
                                kDivergedYawSigma * kDivergedYawSigma;
    const Eigen::Vector3d theta_W(kDivergedTiltSigma, kDivergedTiltSigma,
                                  std::min(std::sqrt(yaw_variance), kUnknownYawSigma));
    StateCovariance& c = now.covariance;
    c.setZero();
    c.block<3, 3>(kTheta, kTheta) = R.transpose() * theta_W.cwiseAbs2().asDiagonal() * R;
    c.block<3, 3>(kPos, kPos) = kept.covariance.block<3, 3>(kPos, kPos);
    c.diagonal().segment<3>(kPos).array() += std::pow(kDivergedPositionSigma, 2);
    c.diagonal().segment<3>(kVel).setConstant(std::pow(kDivergedVelocitySigma, 2));
    c.diagonal().segment<3>(kBiasGyro).setConstant(std::pow(config.initializer.gyro_bias_sigma_rad_per_s, 2));
    c.diagonal().segment<3>(kBiasAccel).setConstant(std::pow(config.initializer.accel_bias_sigma_m_per_s2, 2));
    return Status::kOk;
}

void Estimator::Impl::judge_shaken_rest() {
    may_stand = may_stand && monitor.state() == TrackingState::kInit && tracks.image == ImageState::kUsable &&
                tracks.tracked >= kStandingTracks && tracks.rest_disparity_px <= config.frontend.still_disparity_px;
}

void Estimator::Impl::begin_shaken_rest() {
    InitialState initial;
    if ((now.stamp - window_began).seconds() < kShakenRest_s - kStampSlack_s) {
        return;
    }
    may_stand = false;
    if (!ok(initialize_shaken(imu, {window_began, now.stamp}, gravity_m_per_s2, config.initializer, initial))) {
        return;
    }
    const Belief before = now;
    now.state = initial.state;
    now.covariance = inverse(initial.information());
    begin_window_in_place_of(before);
    rest_claim = RestClaim::kSeen;
    hastened = kHastenedAtRest;
}

void Estimator::Impl::restart_in_motion() {
    InitialState initial;
    if (!ok(initialize_state(imu, now.stamp, gravity_m_per_s2, config.initializer, initial, false))) {
        return;
    }
    const Belief before = now;
    now.state = initial.state;
    now.covariance = inverse(initial.information());
    begin_window_in_place_of(before);
    rests = reset_wanted = false;
    rest_claim = RestClaim::kNone;
    count_reset();
    monitor.restart(now.stamp, false);
}

void Estimator::Impl::restart_in_flight() {
    own_up();
    const bool is_worthless = monitor.has_diverged() || !is_finite(now) || tilt_sigma(now) > kDivergedTiltSigma;
    if (is_worthless && !ok(fall_back_to_gravity())) {
        return;
    }
    // Keeps the covariance from becoming singular by rounding.
    now.covariance = (0.5 * (now.covariance + now.covariance.transpose())).eval();
    now.covariance.diagonal().array() += 1e-10;
    fix_gauge();
    rests = reset_wanted = false;
    rest_claim = RestClaim::kNone;
    is_renewed = true;
    count_reset();
    // What has led the state astray may have led the calibration astray.
    begin_window(inverse(now.covariance), is_worthless ? CalibrationStart::kAsGiven : CalibrationStart::kAsKnown);
    monitor.restart(now.stamp, false);
}

}  // namespace facet
