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

/// A state with its covariance at a stamp of the IMU's clock.
struct Belief {
    Timestamp stamp;
    NavState state;
    StateCovariance covariance = StateCovariance::Zero();
    ImuScale imu_scale;        ///< to carry the state on with
    VibrationShare vibration;  ///< likewise
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

/// Standard deviation of the larger horizontal component of the attitude's error.
inline double tilt_sigma(const Belief& b) {
    const Eigen::Matrix3d R_W_B = b.state.q_W_B.toRotationMatrix();
    const Eigen::Matrix3d theta_W = R_W_B * b.covariance.block<3, 3>(kTheta, kTheta) * R_W_B.transpose();
    return std::sqrt(std::max(theta_W(0, 0), theta_W(1, 1)));
}

}  // namespace facet
