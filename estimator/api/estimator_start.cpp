// SPDX-License-Identifier: BSD-2-Clause
// How the estimator begins a window: at the start, after a second opinion on the start, and anew in flight.
#include <cmath>

#include "estimator/api/estimator_impl.h"
#include "estimator/imu/static_init.h"

namespace facet {
namespace {

// After divergence only the direction of gravity, position and yaw are kept, as uncertain as this:
constexpr double kDivergedTiltSigma = 0.2;      // rad
constexpr double kDivergedVelocitySigma = 2.0;  // m/s
constexpr double kDivergedPositionSigma = 1.0;  // m
constexpr double kDivergedYawSigma = 0.2;       // rad

}  // namespace

void Estimator::Impl::begin_window(const StateCovariance& information, CalibrationStart calibration) {
    window.start(keyframe_input(), now.state, information, calibration);
    if (calibration == CalibrationStart::kAsGiven) {
        forget_corrections();
    }
    phase = Phase::kFollowing;
    now.imu_scale = window.calibration().imu;
    newest = now;
    map.clear();
    summary = {};
    motion_start.reset();
    motion_start.add_keyframe(now.stamp, keyframe_input().observations, imu);
}

void Estimator::Impl::second_opinion() {
    NavState better;
    StateCovariance information;
    if (!ok(motion_start.check(now.state, better, information))) {
        return;
    }
    now.state = better;
    now.covariance = information.inverse();
    begin_window(information, CalibrationStart::kAsGiven);
}

Status Estimator::Impl::fall_back_to_gravity() {
    InitialState initial;
    FACET_TRY(initialize_state(imu, now.stamp, gravity_m_per_s2, config.initializer, initial));
    NavState state = initial.state;
    if (is_finite(now)) {
        const Eigen::Vector3d up_B = initial.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
        const Eigen::Quaterniond turn =
            Eigen::Quaterniond::FromTwoVectors(now.state.q_W_B * up_B, Eigen::Vector3d::UnitZ());
        state.q_W_B = (turn * now.state.q_W_B).normalized();
        state.p_W_B = now.state.p_W_B;
    }
    now.state = state;
    const Eigen::Matrix3d R = state.q_W_B.toRotationMatrix();
    const Eigen::Vector3d theta_W(kDivergedTiltSigma, kDivergedTiltSigma, kDivergedYawSigma);
    StateCovariance& c = now.covariance;
    c.setZero();
    c.block<3, 3>(kTheta, kTheta) = R.transpose() * theta_W.cwiseAbs2().asDiagonal() * R;
    c.diagonal().segment<3>(kPos).setConstant(std::pow(kDivergedPositionSigma, 2));
    c.diagonal().segment<3>(kVel).setConstant(std::pow(kDivergedVelocitySigma, 2));
    c.diagonal().segment<3>(kBiasGyro).setConstant(std::pow(config.initializer.gyro_bias_sigma_rad_per_s, 2));
    c.diagonal().segment<3>(kBiasAccel).setConstant(std::pow(config.initializer.accel_bias_sigma_m_per_s2, 2));
    return Status::kOk;
}

void Estimator::Impl::restart_in_flight() {
    const bool is_worthless = monitor.has_diverged() || !is_finite(now) || tilt_sigma(now) > kDivergedTiltSigma;
    if (is_worthless && !ok(fall_back_to_gravity())) {
        return;
    }
    // Keeps the covariance from becoming singular by rounding.
    now.covariance = (0.5 * (now.covariance + now.covariance.transpose())).eval();
    now.covariance.diagonal().array() += 1e-10;
    rests = reset_wanted = false;
    ++reset_counter;
    // What has led the state astray may have led the calibration astray.
    begin_window(now.covariance.llt().solve(StateCovariance::Identity()),
                 is_worthless ? CalibrationStart::kAsGiven : CalibrationStart::kAsKnown);
    monitor.restart(now.stamp, false);
}

}  // namespace facet
