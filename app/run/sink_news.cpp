// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/sink_news.h"

#include <algorithm>

#include "app/pipeline/to_odometry.h"

namespace facet {
namespace {

constexpr Duration kIdle = Duration::from_seconds(1.0);

}  // namespace

void SinkNews::on_frame(const FrameResult& frame) {
    const Health& health = frame.estimate.health;
    if (last_state_ != health.state) {
        last_state_ = health.state;
        (void)changes_.push({health.state, health.reasons});
    }
    if (frame.has_ranges) {
        (void)ranges_.push(frame.ranges);
    }
}

void SinkNews::report(const std::vector<OdometrySink*>& sinks, TrackingState state, std::uint32_t reasons) {
    const StateChange described = describe_state(state, reasons);
    for (OdometrySink* sink : sinks) {
        sink->report(described);
    }
}

Duration SinkNews::pass_on(const std::vector<OdometrySink*>& sinks) {
    for (Change change; ok(changes_.pop(change));) {
        report(sinks, change.state, change.reasons);
    }
    for (ObstacleRanges ranges; ok(ranges_.pop(ranges));) {
        for (OdometrySink* sink : sinks) {
            (void)sink->send_ranges(ranges);  // sinks count what they cannot send
        }
    }
    Duration soonest = kIdle;
    for (OdometrySink* sink : sinks) {
        if (const Duration period = sink->service_period(); period > Duration{}) {
            sink->service();
            soonest = std::min(soonest, period);
        }
    }
    return soonest;
}

}  // namespace facet
