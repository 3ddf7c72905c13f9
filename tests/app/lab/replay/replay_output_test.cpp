// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/replay_output.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/scripted_source.h"

namespace facet::replay_output_test {
namespace {

class CountingSink final : public OdometrySink {
public:
    std::vector<Odometry> poses;
    std::vector<std::string> texts;
    int serviced = 0;

    Status send(const Odometry& odometry) override {
        poses.push_back(odometry);
        return Status::kOk;
    }
    void report(const StateChange& change) override { texts.emplace_back(change.text.data()); }
    void service() override { ++serviced; }
};

TEST_CASE("in real time a sample waits for its instant, the sink is serviced meanwhile, and lags are not made up for") {
    ManualClock clock({7'000'000'000});
    CountingSink sink;
    ReplayOutput output(clock, &sink, true);
    const std::atomic<bool> stop{false};
    output.wait_for({100'000'000'000}, stop);
    CHECK(clock.now().ns == 7'000'000'000);
    output.wait_for({100'500'000'000}, stop);
    CHECK(clock.now().ns == 7'500'000'000);
    CHECK(sink.serviced >= 10);
    CHECK(output.greatest_lag().ns == 0);
    clock.advance({700'000'000});  // a frame that took long
    output.wait_for({100'600'000'000}, stop);
    CHECK(clock.now().ns == 8'200'000'000);
    CHECK(output.greatest_lag().ns == 600'000'000);
    output.wait_for({101'500'000'000}, stop);
    CHECK(clock.now().ns == 8'500'000'000);
}

TEST_CASE("a wait ends when the replay is to stop, and without real time there is none") {
    ManualClock clock;
    ReplayOutput paced(clock, nullptr, true);
    const std::atomic<bool> stop{true};
    paced.wait_for({0}, stop);
    paced.wait_for({5'000'000'000}, stop);
    CHECK(clock.now().ns == 0);
    CountingSink sink;
    ReplayOutput fast(clock, &sink, false);
    const std::atomic<bool> go_on{false};
    fast.wait_for({0}, go_on);
    fast.wait_for({5'000'000'000}, go_on);
    CHECK(clock.now().ns == 0);
    CHECK(sink.serviced == 2);
}

TEST_CASE("a sink gets what is estimated from the start on, and every change of state") {
    ManualClock clock;
    CountingSink sink;
    ReplayOutput output(clock, &sink, false);
    const ImuNoise noise;
    const auto give = [&](TrackingState state, Status status = Status::kOk) {
        FrameResult frame;
        frame.status = status;
        frame.estimate.health.state = state;
        frame.estimate.health.quality = 60;
        output.give(frame, Eigen::Vector3d::Zero(), noise);
    };
    give(TrackingState::kInit);
    give(TrackingState::kTracking);
    give(TrackingState::kTracking, Status::kInvalidArgument);
    give(TrackingState::kLost);
    REQUIRE(sink.poses.size() == 2);
    CHECK(sink.poses[0].quality == 60);
    CHECK(sink.poses[1].quality == -1);
    CHECK(sink.texts == std::vector<std::string>{"facet: INIT", "facet: TRACKING", "facet: LOST"});
    ReplayOutput nobody(clock, nullptr, false);
    nobody.give(Estimate{}, Eigen::Vector3d::Zero(), noise);
    nobody.report({});
}

}  // namespace
}  // namespace facet::replay_output_test
