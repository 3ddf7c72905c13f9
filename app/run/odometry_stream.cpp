// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/odometry_stream.h"

#include "app/pipeline/to_odometry.h"

namespace facet {

OdometryStream::OdometryStream(const ProgramConfig& config, const VehicleOdometry& options)
    : noise_(config.imu_noise),
      T_body_imu_(options.T_body_imu),
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

Odometry OdometryStream::odometry_of(const Estimate& estimate, const Eigen::Vector3d& w_B) const {
    Odometry odometry = to_odometry(estimate, w_B, noise_, T_body_imu_);
    odometry.is_in_map = T_M_W_.has_value();
    if (T_M_W_) {
        odometry.map_yaw = T_M_W_->yaw;
        odometry.map_p = T_M_W_->p;
    }
    return odometry;
}

bool OdometryStream::add_imu(const ImuSample& sample, Odometry& odometry) {
    if (is_by_frame_ || !carried_.add_imu(sample) || !is_due(sample.stamp)) {
        return false;
    }
    odometry = odometry_of(carried_.estimate(), carried_.newest_rate());
    return true;
}

bool OdometryStream::add_frame(const FrameOutcome& outcome, Odometry& odometry) {
    T_M_W_ = outcome.T_M_W;
    if (!is_by_frame_) {
        carried_.correct(outcome.status, outcome.estimate, outcome.belief);
        return false;
    }
    if (!ok(outcome.status) || outcome.estimate.health.state == TrackingState::kInit) {
        return false;
    }
    odometry = odometry_of(outcome.estimate, outcome.w_B);
    return true;
}

}  // namespace facet
