// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/map_frame.h"

#include <catch2/catch.hpp>

namespace facet::map_frame_test {
namespace {

constexpr double kQuarter = 1.5707963267948966;

Odometry at(const Eigen::Vector3d& p_W) {
    Odometry odometry;
    odometry.p_W_B = p_W;
    odometry.v_W_B = {1.0, 0.0, 0.0};
    odometry.pose_covariance.diagonal() << 1.0, 4.0, 9.0, 0.1, 0.2, 0.3;
    odometry.v_covariance.diagonal() << 1.0, 4.0, 9.0;
    odometry.reset_counter = 255;
    return odometry;
}

Odometry in_map(Odometry odometry, double yaw, const Eigen::Vector3d& p) {
    odometry.is_in_map = true;
    odometry.map_yaw = yaw;
    odometry.map_p = p;
    return odometry;
}

TEST_CASE("before the map is known poses are the odometry's") {
    MapFrame frame;
    const Odometry sent = frame.carried(at({1.0, 2.0, 3.0}));
    CHECK(sent.p_W_B == Eigen::Vector3d(1.0, 2.0, 3.0));
    CHECK(sent.reset_counter == 255);
}

TEST_CASE("pose, velocity and covariances are carried to the map") {
    MapFrame frame;
    const Odometry sent = frame.carried(in_map(at({1.0, 0.0, 3.0}), kQuarter, {10.0, 0.0, 0.0}));
    CHECK(sent.p_W_B.isApprox(Eigen::Vector3d(10.0, 1.0, 3.0)));
    CHECK(sent.v_W_B.isApprox(Eigen::Vector3d(0.0, 1.0, 0.0)));
    CHECK((sent.q_W_B * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
    CHECK(sent.pose_covariance.diagonal().head<3>().isApprox(Eigen::Vector3d(4.0, 1.0, 9.0)));
    CHECK(sent.pose_covariance.diagonal().tail<3>().isApprox(Eigen::Vector3d(0.1, 0.2, 0.3)));
    CHECK(sent.v_covariance.diagonal().isApprox(Eigen::Vector3d(4.0, 1.0, 9.0)));
}

TEST_CASE("only what jumps raises the reset counter") {
    MapFrame frame;
    CHECK(frame.carried(in_map(at({1.0, 0.0, 0.0}), 0.0, {2.0, 0.0, 0.0})).reset_counter == 0);  // located: 255 + 1
    CHECK(frame.carried(in_map(at({1.0, 0.0, 0.0}), 0.0, {2.004, 0.0, 0.0})).reset_counter == 0);
    CHECK(frame.carried(in_map(at({1.0, 0.0, 0.0}), 0.001, {2.004, 0.0, 0.0})).reset_counter == 0);
    CHECK(frame.carried(in_map(at({1.0, 0.0, 0.0}), 0.001, {2.1, 0.0, 0.0})).reset_counter == 1);
    CHECK(frame.carried(in_map(at({0.0, 0.0, 0.0}), 0.05, {2.1, 0.0, 0.0})).reset_counter == 2);
}

TEST_CASE("while the pose in the map is unknown again the last correction stays") {
    MapFrame frame;
    (void)frame.carried(in_map(at({1.0, 0.0, 0.0}), 0.0, {2.0, 0.0, 0.0}));
    const Odometry sent = frame.carried(at({1.5, 0.0, 0.0}));
    CHECK(sent.p_W_B.isApprox(Eigen::Vector3d(3.5, 0.0, 0.0)));
    CHECK(sent.reset_counter == 0);
}

}  // namespace
}  // namespace facet::map_frame_test
