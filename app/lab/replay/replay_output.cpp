// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/replay_output.h"

#include <algorithm>

#include "app/pipeline/to_odometry.h"

namespace facet {
namespace {

constexpr Duration kLongestSleep = Duration::from_seconds(0.05);

}  // namespace

void ReplayOutput::wait_for(Timestamp stamp, const std::atomic<bool>& stop) {
    if (sink_ != nullptr) {
        sink_->service();
    }
    if (!in_real_time_) {
        return;
    }
    if (!shift_) {
        shift_ = clock_.now() - stamp;
    }
    const Timestamp due = stamp + *shift_;
    greatest_lag_ = std::max(greatest_lag_, clock_.now() - due);
    while (clock_.now() < due && !stop.load()) {
        clock_.sleep_until(std::min(due, clock_.now() + kLongestSleep));
        if (sink_ != nullptr) {
            sink_->service();
        }
    }
}

void ReplayOutput::report(const Health& health) {
    if (sink_ != nullptr && last_state_ != health.state) {
        last_state_ = health.state;
        sink_->report(describe_state(health.state, health.reasons));
    }
}

void ReplayOutput::give(const FrameResult& frame, const Eigen::Vector3d& w_B, const ImuNoise& noise) {
    report(frame.estimate.health);
    if (ok(frame.status) && frame.estimate.health.state != TrackingState::kInit) {
        give(frame.estimate, w_B, noise);
    }
}

void ReplayOutput::give(const Estimate& estimate, const Eigen::Vector3d& w_B, const ImuNoise& noise) {
    if (sink_ != nullptr) {
        (void)sink_->send(to_odometry(estimate, w_B, noise));  // the sink counts what it cannot send
    }
}

}  // namespace facet
