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

}  // namespace

Odometry to_odometry(const Estimate& estimate, const Eigen::Vector3d& w_B, const ImuNoise& noise) {
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
