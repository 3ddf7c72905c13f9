// SPDX-License-Identifier: BSD-2-Clause
// The frames of MAVLink: from x forward, y left, z up to x forward, y right, z down.
#pragma once

#include <Eigen/Core>

#include "platform/port/odometry_sink.h"

namespace facet {

/// The local frame L that estimates are given in: W turned about the vertical and shifted, so that a place can be home
/// and a heading can be known.
///   p_L = Rz(yaw) p_W + t
struct LocalFrame {
    double yaw_rad = 0.0;
    Eigen::Vector3d t = Eigen::Vector3d::Zero();  ///< (m)
};

/// An estimate in FRD frames: F is MAV_FRAME_LOCAL_FRD, b is MAV_FRAME_BODY_FRD, D = diag(1, -1, -1).
///
///   | quantity              | ours                  | here                                          |
///   |-----------------------|-----------------------|-----------------------------------------------|
///   | position              | p_L = Rz(yaw) p_W + t | p_F = D p_L                                   |
///   | attitude              | q_L_B                 | q_F_b = (w, x, -y, -z), w >= 0                |
///   | velocity              | v_W                   | v_F = D Rz(yaw) v_W, v_b = D R_W_B^T v_W      |
///   | angular rate          | w_B                   | w_b = D w_B                                   |
///   | covariance of p       | in W                  | D Rz(yaw) C Rz(yaw)^T D                       |
///   | covariance of theta   | right perturbation, B | of roll, pitch, yaw: E D C D E^T              |
///   | covariance of v       | in W                  | in b: D R_W_B^T C R_W_B D; in F: as that of p |
///   | covariance of w       | in B                  | D C D                                         |
///
/// roll, pitch and yaw are those of R_F_b = Rz(yaw) Ry(pitch) Rx(roll), and d(roll, pitch, yaw) = E d(theta_b), the
/// matrix that turns body rates into their derivatives; near a vertical nose, where it grows without bound, cos(pitch)
/// counts as kMinCosPitch. Cross terms of position and attitude are turned along.
struct FrdOdometry {
    static constexpr double kMinCosPitch = 0.1;

    Timestamp stamp;
    Eigen::Vector3d p_F = Eigen::Vector3d::Zero();
    Eigen::Vector4d q_F_b_wxyz = Eigen::Vector4d::UnitX();
    Eigen::Vector3d rpy_rad = Eigen::Vector3d::Zero();
    Eigen::Vector3d v_F = Eigen::Vector3d::Zero();
    Eigen::Vector3d v_b = Eigen::Vector3d::Zero();
    Eigen::Vector3d w_b = Eigen::Vector3d::Zero();
    Matrix6d pose_covariance = Matrix6d::Zero();               ///< [p_F, roll, pitch, yaw]
    Matrix6d twist_covariance = Matrix6d::Zero();              ///< [v_b, w_b]
    Eigen::Matrix3d v_F_covariance = Eigen::Matrix3d::Zero();  ///< of v_F
    int quality = 0;
    std::uint8_t reset_counter = 0;
};

/// @return kInvalidArgument if a number is not finite, a variance not positive, the quaternion's length not 1, or the
///         quality out of range: output untouched. Reentrant. No heap.
Status to_frd(const Odometry& odometry, const LocalFrame& local, FrdOdometry& frd);

/// Heading of the body's x axis in W, counterclockwise from W's x axis (rad). Reentrant.
double heading_of(const Odometry& odometry);

/// The local frame with its origin at this estimate's position; yaw as it was. Reentrant.
LocalFrame with_home_at(const LocalFrame& local, const Odometry& odometry);
/// The local frame in which this estimate's body has the compass heading (rad, clockwise), at the place where it was.
LocalFrame with_heading(const LocalFrame& local, const Odometry& odometry, double heading_rad);

}  // namespace facet
