// SPDX-License-Identifier: BSD-2-Clause
// What the sinks are given besides poses, on its way from the estimator's thread to theirs.
#pragma once

#include <optional>
#include <vector>

#include "app/pipeline/frame_pipeline.h"
#include "platform/base/spsc_queue.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// Changes of state and distances to obstacles; it also has the sinks do what is due between estimates. When a queue is
/// full, the newest is lost: the next one follows. The estimator's side uses neither heap nor lock.
class SinkNews {
public:
    // On the estimator's thread:
    void on_frame(const FrameResult& frame);

    // On the sinks' thread:
    /// @return how soon it wants to be called again
    Duration pass_on(const std::vector<OdometrySink*>& sinks);
    /// Reports a state that the estimator's thread cannot report itself.
    static void report(const std::vector<OdometrySink*>& sinks, TrackingState state, std::uint32_t reasons);

private:
    struct Change {
        TrackingState state = TrackingState::kInit;
        std::uint32_t reasons = 0;
    };

    std::optional<TrackingState> last_state_;
    SpscQueue<Change, 16> changes_;
    SpscQueue<ObstacleRanges, 4> ranges_;
};

}  // namespace facet
