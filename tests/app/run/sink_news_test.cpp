// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/sink_news.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace facet::sink_news_test {
namespace {

class ListeningSink final : public OdometrySink {
public:
    std::vector<std::string> texts;
    std::vector<ObstacleRanges> ranges;
    int serviced = 0;
    Duration period;

    Status send(const Odometry&) override { return Status::kOk; }
    void report(const StateChange& change) override { texts.emplace_back(change.text.data()); }
    Status send_ranges(const ObstacleRanges& r) override {
        ranges.push_back(r);
        return Status::kOk;
    }
    void service() override { ++serviced; }
    Duration service_period() const override { return period; }
};

FrameResult frame_in_state(TrackingState state, std::uint32_t reasons) {
    FrameResult frame;
    frame.estimate.health.state = state;
    frame.estimate.health.reasons = reasons;
    return frame;
}

TEST_CASE("changes of state reach the sinks in words, once each; reasons alone are no change") {
    SinkNews news;
    ListeningSink sink;
    const test::AllocationGuard guard;
    news.on_frame(frame_in_state(TrackingState::kInit, 0));
    news.on_frame(frame_in_state(TrackingState::kTracking, 0));
    news.on_frame(frame_in_state(TrackingState::kTracking, kReasonVibration));
    news.on_frame(frame_in_state(TrackingState::kDegraded, kReasonFewFeatures | kReasonVibration));
    news.on_frame(frame_in_state(TrackingState::kLost, ~0U));
    const auto allocations = guard.allocations();
    CHECK(allocations == 0);
    (void)news.pass_on({&sink});
    REQUIRE(sink.texts.size() == 4);
    CHECK(sink.texts[0] == "facet: INIT");
    CHECK(sink.texts[1] == "facet: TRACKING");
    CHECK(sink.texts[2] == "facet: DEGRADED few_features|vibration");
    CHECK(sink.texts[3].size() == 50);
    CHECK(sink.texts[3].starts_with("facet: LOST few_features|few_stereo"));
    (void)news.pass_on({&sink});
    CHECK(sink.texts.size() == 4);
}

TEST_CASE("ranges are passed on, and sinks are serviced as often as they ask for") {
    SinkNews news;
    ListeningSink lazy;
    ListeningSink busy;
    busy.period = Duration::from_seconds(0.002);
    FrameResult frame = frame_in_state(TrackingState::kTracking, 0);
    frame.has_ranges = true;
    frame.ranges.range_m[3] = 2.5F;
    news.on_frame(frame);
    CHECK(news.pass_on({&lazy}) > Duration::from_seconds(0.1));
    CHECK(lazy.ranges.size() == 1);
    CHECK(lazy.ranges[0].range_m[3] == 2.5F);
    CHECK(lazy.serviced == 0);
    CHECK(news.pass_on({&lazy, &busy}) == busy.period);
    CHECK(busy.serviced == 1);
}

}  // namespace
}  // namespace facet::sink_news_test
