// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/frd.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

bool is_usable(const Odometry& o) {
    const bool finite = o.q_W_B.coeffs().allFinite() && o.p_W_B.allFinite() && o.v_W_B.allFinite() &&
                        o.w_B.allFinite() && o.pose_covariance.allFinite() && o.v_covariance.allFinite() &&
                        o.w_covariance.allFinite();
    return finite && std::abs(o.q_W_B.norm() - 1.0) < 1e-3 && (o.pose_covariance.diagonal().array() > 0.0).all() &&
           (o.v_covariance.diagonal().array() > 0.0).all() && (o.w_covariance.diagonal().array() > 0.0).all() &&
           o.quality >= -1 && o.quality <= 100;
}

Eigen::Matrix3d turn_about_z(double yaw_rad) {
    return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

/// Roll, pitch and yaw of R = Rz Ry Rx.
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R) {
    return {std::atan2(R(2, 1), R(2, 2)), std::asin(std::clamp(-R(2, 0), -1.0, 1.0)), std::atan2(R(1, 0), R(0, 0))};
}

/// Derivative of these with respect to a rotation in the body. R's last row is (-sin p, sin r cos p, cos r cos p).
Eigen::Matrix3d rates_of_angles(const Eigen::Matrix3d& R) {
    const double cos_p = std::hypot(R(2, 1), R(2, 2));
    const double sin_r = cos_p > 0.0 ? R(2, 1) / cos_p : 0.0;
    const double cos_r = cos_p > 0.0 ? R(2, 2) / cos_p : 1.0;
    const double divisor = std::max(cos_p, FrdOdometry::kMinCosPitch);
    const double tan_p = -R(2, 0) / divisor;
    Eigen::Matrix3d E;
    E << 1.0, sin_r * tan_p, cos_r * tan_p, 0.0, cos_r, -sin_r, 0.0, sin_r / divisor, cos_r / divisor;
    return E;
}

}  // namespace

Status to_frd(const Odometry& odometry, const LocalFrame& local, FrdOdometry& frd) {
    if (!is_usable(odometry)) {
        return Status::kInvalidArgument;
    }
    const Eigen::DiagonalMatrix<double, 3> D(1.0, -1.0, -1.0);
    const Eigen::Matrix3d R_L_W = turn_about_z(local.yaw_rad);
    const Eigen::Matrix3d R_W_B = odometry.q_W_B.normalized().toRotationMatrix();
    const Eigen::Matrix3d R_F_W = D * R_L_W;
    const Eigen::Matrix3d R_b_W = D * R_W_B.transpose();
    const Eigen::Quaterniond q_L_B =
        Eigen::AngleAxisd(local.yaw_rad, Eigen::Vector3d::UnitZ()) * odometry.q_W_B.normalized();

    frd.stamp = odometry.stamp;
    frd.p_F = D * (R_L_W * odometry.p_W_B + local.t);
    frd.q_F_b_wxyz << q_L_B.w(), q_L_B.x(), -q_L_B.y(), -q_L_B.z();
    frd.q_F_b_wxyz *= q_L_B.w() < 0.0 ? -1.0 : 1.0;
    const Eigen::Matrix3d R_F_b = R_F_W * R_W_B * D;
    frd.rpy_rad = roll_pitch_yaw(R_F_b);
    frd.v_F = R_F_W * odometry.v_W_B;
    frd.v_b = R_b_W * odometry.v_W_B;
    frd.w_b = D * odometry.w_B;

    Matrix6d turn = Matrix6d::Zero();
    turn.topLeftCorner<3, 3>() = R_F_W;
    turn.bottomRightCorner<3, 3>() = rates_of_angles(R_F_b) * D;
    frd.pose_covariance = turn * odometry.pose_covariance * turn.transpose();
    frd.twist_covariance.setZero();
    frd.twist_covariance.topLeftCorner<3, 3>() = R_b_W * odometry.v_covariance * R_b_W.transpose();
    frd.twist_covariance.bottomRightCorner<3, 3>() = D * odometry.w_covariance * D;
    frd.v_F_covariance = R_F_W * odometry.v_covariance * R_F_W.transpose();
    frd.quality = odometry.quality;
    frd.reset_counter = odometry.reset_counter;
    return Status::kOk;
}

double heading_of(const Odometry& odometry) {
    const Eigen::Vector3d x_W = odometry.q_W_B * Eigen::Vector3d::UnitX();
    return std::atan2(x_W.y(), x_W.x());
}

LocalFrame with_home_at(const LocalFrame& local, const Odometry& odometry) {
    return {local.yaw_rad, -(turn_about_z(local.yaw_rad) * odometry.p_W_B)};
}

LocalFrame with_heading(const LocalFrame& local, const Odometry& odometry, double heading_rad) {
    const Eigen::Vector3d p_L = turn_about_z(local.yaw_rad) * odometry.p_W_B + local.t;
    LocalFrame turned{-heading_rad - heading_of(odometry), {}};
    turned.t = p_L - turn_about_z(turned.yaw_rad) * odometry.p_W_B;
    return turned;
}

}  // namespace facet
