// SPDX-License-Identifier: BSD-2-Clause
// A replay's way to a sink, and its pace.
#pragma once

#include <atomic>
#include <optional>

#include "app/pipeline/frame_pipeline.h"
#include "platform/port/clock.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// Gives a sink what a replay estimates. In real time a sample waits until as much time has passed since the first one
/// as in the log; a replay that falls behind is not slowed down further. Thread-bound. Clock and sink are borrowed.
class ReplayOutput {
public:
    /// @param sink  nullptr: nobody listens
    ReplayOutput(Clock& clock, OdometrySink* sink, bool in_real_time)
        : clock_(clock), sink_(sink), in_real_time_(in_real_time) {}

    /// Waits for the instant of a sample, and has the sink do what is due. @param stop  ends the wait
    void wait_for(Timestamp stamp, const std::atomic<bool>& stop);
    /// A frame, or what the estimator says while none comes. @param w_B  newest angular rate, as measured
    void give(const FrameResult& frame, const Eigen::Vector3d& w_B, const ImuNoise& noise);
    /// An estimate at an inertial sample.
    void give(const Estimate& estimate, const Eigen::Vector3d& w_B, const ImuNoise& noise);
    /// A change of state.
    void report(const Health& health);

    /// The longest that the replay has been behind the log.
    Duration greatest_lag() const { return greatest_lag_; }

private:
    Clock& clock_;
    OdometrySink* sink_;
    bool in_real_time_;
    std::optional<Duration> shift_;  ///< from the log's time to the clock's
    Duration greatest_lag_;
    std::optional<TrackingState> last_state_;
};

}  // namespace facet
