// SPDX-License-Identifier: BSD-2-Clause
// A state and how well it is known.
#pragma once

#include <algorithm>
#include <cmath>

#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/propagation.h"
#include "estimator/imu/vibration_share.h"
#include "estimator/values/nav_state.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Readings of a sensor under suspicion, and what replaces them.
struct ReplacedReadings {
    ImuAxisMask axes = 0;  ///< of the sensors; none: all are trusted
    SteadyMotion motion;
    StepNoise noise;  ///< beyond the sensor's own
};

/// A state with its covariance at a stamp of the IMU's clock.
struct Belief {
    Timestamp stamp;
    NavState state;
    StateCovariance covariance = StateCovariance::Zero();
    ImuScale imu_scale;         ///< for propagating the state
    VibrationShare vibration;   ///< likewise
    ReplacedReadings replaced;  ///< after the stamp
};

inline bool is_finite(const Belief& b) {
    return b.state.q_W_B.coeffs().allFinite() && b.state.p_W_B.allFinite() && b.state.v_W_B.allFinite() &&
           b.state.bias.gyro.allFinite() && b.state.bias.accel.allFinite() && b.covariance.allFinite();
}

/// Adds to a covariance, order [theta p v ...], what vibration makes the velocity differ from the motion's by at the
/// newest sample.
template <int kDim>
void add_ripple(const ImuBuffer& imu, const NavState& state, Eigen::Matrix<double, kDim, kDim>& covariance) {
    const Eigen::Matrix3d R_W_B = state.q_W_B.toRotationMatrix();
    const Eigen::Matrix3d ripple = R_W_B * imu.velocity_ripple().asDiagonal() * R_W_B.transpose();
    covariance.template block<3, 3>(kVel, kVel) += 0.5 * (ripple + ripple.transpose());
}

/// Rotates a belief about the vertical until its attitude is closest to another one; its position stays.
/// The angle a maximises trace(Rz(a)^T R), R the turn between the attitudes: a = atan2(R10 - R01, R00 + R11).
inline void turn_to_yaw_of(const Eigen::Quaterniond& q_W_B, Belief& b) {
    const Eigen::Matrix3d R = (q_W_B * b.state.q_W_B.conjugate()).toRotationMatrix();
    const Eigen::AngleAxisd turn(std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)), Eigen::Vector3d::UnitZ());
    const Eigen::Matrix3d R_turn = turn.toRotationMatrix();
    b.state.q_W_B = (turn * b.state.q_W_B).normalized();
    b.state.v_W_B = R_turn * b.state.v_W_B;
    for (const int part : {kPos, kVel}) {  // in W; the other parts are in B
        b.covariance.middleRows<3>(part) = (R_turn * b.covariance.middleRows<3>(part)).eval();
        b.covariance.middleCols<3>(part) = (b.covariance.middleCols<3>(part) * R_turn.transpose()).eval();
    }
}

/// Largest standard deviation of an axis of the velocity relative to the body's heading: the velocity's error less what
/// an error of the yaw alone makes of it, which turns the way flown with the body. With up = R_B^W z and e the yaw's:
///   dv - (z x v) e,    e = up . theta
inline double velocity_sigma(const Belief& b) {
    const Eigen::Vector3d up_B = b.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    Eigen::Matrix<double, 3, 9> d = Eigen::Matrix<double, 3, 9>::Zero();
    d.leftCols<3>() = -Eigen::Vector3d::UnitZ().cross(b.state.v_W_B) * up_B.transpose();
    d.rightCols<3>().setIdentity();
    const Eigen::Matrix3d relative = d * b.covariance.topLeftCorner<9, 9>() * d.transpose();
    return std::sqrt(std::max(0.0, relative.diagonal().maxCoeff()));
}

/// Standard deviation of the larger horizontal component of the attitude's error.
inline double tilt_sigma(const Belief& b) {
    const Eigen::Matrix3d R_W_B = b.state.q_W_B.toRotationMatrix();
    const Eigen::Matrix3d theta_W = R_W_B * b.covariance.block<3, 3>(kTheta, kTheta) * R_W_B.transpose();
    return std::sqrt(std::max(theta_W(0, 0), theta_W(1, 1)));
}

}  // namespace facet
