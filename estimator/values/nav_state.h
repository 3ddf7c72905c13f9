// SPDX-License-Identifier: BSD-2-Clause
// The navigation state and its tangent space.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "estimator/geometry/se3.h"

namespace facet {

/// Bias of the IMU: its reading minus the true value.
struct ImuBias {
    Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< (rad/s)
    Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< (m/s^2)
};

/// Navigation state of the body. Tangent order [theta p v bg ba], each 3; see state_offset.
struct NavState {
    Eigen::Quaterniond q_W_B = Eigen::Quaterniond::Identity();
    Eigen::Vector3d p_W_B = Eigen::Vector3d::Zero();  ///< (m)
    Eigen::Vector3d v_W_B = Eigen::Vector3d::Zero();  ///< (m/s)
    ImuBias bias;

    Se3 T_W_B() const { return {q_W_B, p_W_B}; }
    NavState box_plus(const Eigen::Matrix<double, 15, 1>& d) const;
    /// The d with other = box_plus(d).
    Eigen::Matrix<double, 15, 1> box_minus_to(const NavState& other) const;
};

/// Offsets of the parts in a state's tangent vector.
inline constexpr int kTheta = 0;
inline constexpr int kPos = 3;
inline constexpr int kVel = 6;
inline constexpr int kBiasGyro = 9;
inline constexpr int kBiasAccel = 12;
inline constexpr int kStateDim = 15;
inline constexpr int kPoseDim = 6;

/// Gravity in the world, whose z is up. @param norm_m_per_s2  GravityConfig::magnitude_m_per_s2
inline Eigen::Vector3d gravity_W(double norm_m_per_s2) { return {0.0, 0.0, -norm_m_per_s2}; }

}  // namespace facet
