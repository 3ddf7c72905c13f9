// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/odometry_stream.h"

namespace facet {

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
    return odometry;
}

OdometryStream::OdometryStream(const ProgramConfig& config, const VehicleOdometry& options)
    : noise_(config.imu_noise),
      carried_(config, options.smoothing_s),
      is_by_frame_(options.rate_hz <= 0.0),
      period_(Duration::from_seconds(is_by_frame_ ? 0.0 : 1.0 / options.rate_hz)),
      tolerance_(Duration::from_seconds(0.5 / config.imu_noise.rate_hz)) {}

/// Due instants lie on a grid, so that the mean rate is the one asked for; after a pause the grid begins anew.
bool OdometryStream::is_due(Timestamp stamp) {
    if (any_ && stamp + tolerance_ < due_) {
        return false;
    }
    const bool is_late = !any_ || stamp - due_ > period_;
    due_ = (is_late ? stamp : due_) + period_;
    any_ = true;
    return true;
}

bool OdometryStream::add_imu(const ImuSample& sample, Odometry& odometry) {
    if (is_by_frame_ || !carried_.add_imu(sample) || !is_due(sample.stamp)) {
        return false;
    }
    odometry = to_odometry(carried_.estimate(), sample.w_B, noise_);
    return true;
}

bool OdometryStream::add_frame(const FrameOutcome& outcome, Odometry& odometry) {
    if (!is_by_frame_) {
        carried_.correct(outcome.status, outcome.estimate, outcome.belief);
        return false;
    }
    if (!ok(outcome.status) || outcome.estimate.health.state == TrackingState::kInit) {
        return false;
    }
    odometry = to_odometry(outcome.estimate, outcome.w_B, noise_);
    return true;
}

}  // namespace facet
