// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/map_frame.h"

#include <cmath>
#include <numbers>

namespace facet {

Odometry MapFrame::carried(const Odometry& odometry) {
    const auto turn = [](double yaw) { return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()); };
    if (odometry.is_in_map) {
        const double by = std::remainder(odometry.map_yaw - yaw_, 2.0 * std::numbers::pi);
        const Eigen::Vector3d moved =
            (turn(odometry.map_yaw) * odometry.p_W_B + odometry.map_p) - (turn(yaw_) * odometry.p_W_B + p_);
        jumps_ = static_cast<std::uint8_t>(jumps_ + (moved.norm() > kJump_m || std::abs(by) > kJump_rad ? 1 : 0));
        yaw_ = odometry.map_yaw;
        p_ = odometry.map_p;
    }
    Odometry in_map = odometry;
    in_map.q_W_B = (turn(yaw_) * odometry.q_W_B).normalized();
    in_map.p_W_B = turn(yaw_) * odometry.p_W_B + p_;
    in_map.v_W_B = turn(yaw_) * odometry.v_W_B;
    const Eigen::Matrix3d R = turn(yaw_).toRotationMatrix();
    Matrix6d J = Matrix6d::Identity();  // the attitude's error is in B
    J.topLeftCorner<3, 3>() = R;
    in_map.pose_covariance = J * odometry.pose_covariance * J.transpose();
    in_map.v_covariance = R * odometry.v_covariance * R.transpose();
    in_map.reset_counter = static_cast<std::uint8_t>(odometry.reset_counter + jumps_);
    return in_map;
}

}  // namespace facet
