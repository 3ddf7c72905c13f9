// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/to_odometry.h"

#include <fmt/core.h>

#include <string>

#include "app/output/frame_log.h"

namespace facet {
namespace {

constexpr SinkState sink_state(TrackingState state) {
    switch (state) {
        case TrackingState::kInit: return SinkState::kInit;
        case TrackingState::kTracking: return SinkState::kTracking;
        case TrackingState::kDegraded: return SinkState::kDegraded;
        case TrackingState::kLost: return SinkState::kLost;
    }
    return SinkState::kLost;
}

bool is_identity(const Se3& T) { return T.q.vec().isZero(0.0) && T.p.isZero(0.0); }

/// From B to V, see to_odometry().
/// @param covariance  of the estimate: [theta p v]
void move_to_body(const Se3& T_V_B, const Eigen::Matrix<double, 9, 9>& covariance, Odometry& odometry) {
    const Se3 T_B_V = T_V_B.inverse();
    const Eigen::Matrix3d R_W_B = odometry.q_W_B.toRotationMatrix();
    const Eigen::Matrix3d R_V_B = T_V_B.R();
    const Eigen::Vector3d& r_B = T_B_V.p;
    const Eigen::Vector3d swing_B = odometry.w_B.cross(r_B);
    Eigen::Matrix<double, 9, 9> J = Eigen::Matrix<double, 9, 9>::Identity();
    J.block<3, 3>(0, 0) = R_V_B;
    J.block<3, 3>(3, 0) = -R_W_B * skew(r_B);
    J.block<3, 3>(6, 0) = -R_W_B * skew(swing_B);
    const Eigen::Matrix<double, 9, 9> c = J * covariance * J.transpose();
    const Eigen::Matrix3d d_v_d_w = -R_W_B * skew(r_B);
    odometry.pose_covariance << c.block<3, 3>(3, 3), c.block<3, 3>(3, 0), c.block<3, 3>(0, 3), c.block<3, 3>(0, 0);
    odometry.v_covariance = c.block<3, 3>(6, 6) + d_v_d_w * odometry.w_covariance * d_v_d_w.transpose();
    odometry.w_covariance = (R_V_B * odometry.w_covariance * R_V_B.transpose()).eval();
    odometry.p_W_B += R_W_B * r_B;
    odometry.v_W_B += R_W_B * swing_B;
    odometry.q_W_B = (odometry.q_W_B * T_B_V.q).normalized();
    odometry.w_B = (R_V_B * odometry.w_B).eval();
}

}  // namespace

Odometry to_odometry(const Estimate& estimate, const Eigen::Vector3d& w_B, const ImuNoise& noise,
                     const Se3& T_body_imu) {
    const NavState& state = estimate.state;
    Odometry odometry;
    odometry.stamp = estimate.stamp;
    odometry.q_W_B = state.q_W_B;
    odometry.p_W_B = state.p_W_B;
    odometry.v_W_B = state.v_W_B;
    odometry.w_B = w_B - state.bias.gyro;
    // The estimate's order is [theta p v], that of sinks [p theta].
    const auto& c = estimate.covariance;
    odometry.pose_covariance << c.block<3, 3>(3, 3), c.block<3, 3>(3, 0), c.block<3, 3>(0, 3), c.block<3, 3>(0, 0);
    odometry.v_covariance = c.block<3, 3>(6, 6);
    const double density = noise.gyro_noise_rad_per_s_per_sqrt_hz;
    odometry.w_covariance = Eigen::Matrix3d::Identity() * (density * density * noise.rate_hz);
    odometry.quality = estimate.health.state == TrackingState::kLost ? -1 : estimate.health.quality;
    odometry.reset_counter = static_cast<std::uint8_t>(estimate.health.reset_counter & 0xffU);
    if (!is_identity(T_body_imu)) {
        move_to_body(T_body_imu, estimate.covariance, odometry);
    }
    odometry.state = sink_state(estimate.health.state);
    odometry.reasons = estimate.health.reasons;
    return odometry;
}

StateChange describe_state(TrackingState state, std::uint32_t reasons) {
    StateChange change{.state = sink_state(state), .text = {}, .reasons = reasons};
    const std::string names = reason_names(reasons);
    fmt::format_to_n(change.text.data(), change.text.size() - 1, "facet: {}{}{}", to_string(state),
                     names.empty() ? "" : " ", names);
    return change;
}

}  // namespace facet
