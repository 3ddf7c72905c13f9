// SPDX-License-Identifier: BSD-2-Clause
// Carries estimates from the sinks' thread to the one that a MavlinkLink belongs to.
#pragma once

#include "drivers/mavlink/mavlink_link.h"
#include "platform/base/spsc_queue.h"

namespace facet {

/// A link whose flight controller's inertial sensor is used belongs to that sensor's thread, which may not wait for
/// the sinks'. What the sinks are to send waits here until that thread, which looks every 2 ms, passes it on: 32
/// estimates, eight changes of state and four sweeps of obstacles at most; when full, new ones are refused. Thread-safe
/// for one sending and one passing thread. No heap.
class MavlinkOutbox final : public OdometrySink {
public:
    /// @return kFull if nothing is passed on: dropped
    Status send(const Odometry& odometry) override { return estimates_.push(odometry); }
    void report(const StateChange& change) override { (void)changes_.push(change); }
    Status send_ranges(const ObstacleRanges& ranges) override { return ranges_.push(ranges); }

    /// On the link's thread: sends what waits. What the link refuses it counts itself.
    void pass_on(MavlinkLink& link);

private:
    SpscQueue<Odometry, 32> estimates_;
    SpscQueue<StateChange, 8> changes_;
    SpscQueue<ObstacleRanges, 4> ranges_;
};

}  // namespace facet
