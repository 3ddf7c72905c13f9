// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/odometry_message.h"

namespace facet {
namespace {

using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

bool is_covariance(const auto& covariance) {
    return covariance.allFinite() && (covariance.diagonal().array() > 0.0).all();
}

}  // namespace

Ros2Odometry to_ros2(const Odometry& odometry, Timestamp stamp) {
    Ros2Odometry message;
    message.stamp = stamp;
    message.p = odometry.p_W_B;
    message.q = odometry.q_W_B.normalized();
    const Eigen::Matrix3d R = message.q.toRotationMatrix();
    Matrix6d turn = Matrix6d::Identity();
    turn.bottomRightCorner<3, 3>() = R;
    Eigen::Map<RowMajor6d>(message.pose_covariance.data()) = turn * odometry.pose_covariance * turn.transpose();
    message.v_B = R.transpose() * odometry.v_W_B;
    message.w_B = odometry.w_B;
    Eigen::Map<RowMajor6d> twist(message.twist_covariance.data());
    twist.topLeftCorner<3, 3>() = R.transpose() * odometry.v_covariance * R;
    twist.bottomRightCorner<3, 3>() = odometry.w_covariance;
    return message;
}

bool is_publishable(const Odometry& odometry) {
    return odometry.q_W_B.coeffs().allFinite() && odometry.q_W_B.norm() > 0.5 && odometry.p_W_B.allFinite() &&
           odometry.v_W_B.allFinite() && odometry.w_B.allFinite() && is_covariance(odometry.pose_covariance) &&
           is_covariance(odometry.v_covariance) && is_covariance(odometry.w_covariance);
}

}  // namespace facet
