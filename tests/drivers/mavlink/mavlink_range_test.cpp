// SPDX-License-Identifier: BSD-2-Clause
// A flight controller's range finder, on its way to the estimator.
#include "drivers/mavlink/mavlink_range.h"

#include <catch2/catch.hpp>

#include "tests/drivers/mavlink/link_scene.h"

namespace facet::mavlink_range_test {
namespace {

using test::Scene;

constexpr Duration kAhead{-90'000'000'000};  // the controller's clock against ours

MavDistance down(std::uint16_t distance_cm) {
    return {.min_cm = 20, .max_cm = 1200, .distance_cm = distance_cm, .id = 2, .orientation = 25};
}

struct RangeScene : Scene {
    explicit RangeScene(Duration latency = {}) : Scene(options_with(latency)) { link.give_ranges_to(&queue); }

    static MavlinkOptions options_with(Duration latency) {
        MavlinkOptions options;
        options.time = MavlinkTime::kOwn;
        options.range = MavlinkRangeOptions{
            .id = 2, .latency = latency, .place_B = {0.1, 0.0, -0.05}, .down_B = -Eigen::Vector3d::UnitZ()};
        return options;
    }
    void synchronise() {
        for (std::size_t i = 0; i < TimesyncFilter::kBlock + 2; ++i) {
            link.service();
            for (const MavlinkPacket& question : heard(MavlinkId::kTimesync)) {
                const MavTimesync asked = decode_timesync(question.payload);
                clock.advance({1'000'000});
                const std::int64_t theirs = (clock.now() + kAhead).ns;
                clock.advance({1'000'000});
                Scene::say(MavTimesync{theirs, asked.ts1_ns, {1, 197}});
                link.service();
            }
            clock.advance({98'000'000});
        }
        REQUIRE(link.timesync().ready());
    }
    /// A reading of `age` ago.
    void measure(const MavDistance& distance, Duration age = {}) {
        MavlinkPayload payload;
        MavlinkWriter out(payload);
        out.put(static_cast<std::uint32_t>((clock.now() - age + kAhead).ns / 1'000'000));
        out.put(distance.min_cm);
        out.put(distance.max_cm);
        out.put(distance.distance_cm);
        out.put(std::uint8_t{0});
        out.put(distance.id);
        out.put(distance.orientation);
        out.put(std::uint8_t{0});
        for (int i = 0; i < 6; ++i) {
            out.put_float(0.0);
        }
        out.put(distance.quality);
        Scene::say(MavlinkId::kDistanceSensor, payload);
        link.service();
    }

    RangeQueue queue;
};

TEST_CASE("a reading is a point of the ground in the body, stamped in our time") {
    RangeScene scene(Duration{5'000'000});
    scene.synchronise();
    scene.measure(down(153), Duration{10'000'000});
    RangeSample sample;
    REQUIRE(ok(scene.queue.pop(sample)));
    CHECK(sample.p_B.isApprox(Eigen::Vector3d(0.1, 0.0, -0.05 - 1.53)));
    CHECK((scene.clock.now() - sample.stamp).seconds() == Approx(0.015).margin(2e-3));
    CHECK(scene.link.counters().ranges == 1);
}

TEST_CASE("a reading is never later than its arrival") {
    RangeScene scene;
    scene.synchronise();
    scene.measure(down(153), Duration{-20'000'000});
    RangeSample sample;
    REQUIRE(ok(scene.queue.pop(sample)));
    CHECK(sample.stamp == scene.clock.now());
}

TEST_CASE("what does not look down, is out of range or invalid, or comes without a time is refused") {
    RangeScene scene;
    RangeSample sample;
    scene.measure(down(153));  // its clock is not known yet
    CHECK_FALSE(ok(scene.queue.pop(sample)));
    scene.synchronise();
    MavDistance ahead = down(153);
    ahead.orientation = 0;
    MavDistance invalid = down(153);
    invalid.quality = 1;
    for (const MavDistance& distance : {down(20), down(1200), ahead, invalid}) {
        scene.measure(distance);
        CHECK_FALSE(ok(scene.queue.pop(sample)));
    }
    CHECK(scene.link.counters().ranges_refused == 5);
    MavDistance other = down(153);
    other.id = 1;
    scene.measure(other);
    CHECK_FALSE(ok(scene.queue.pop(sample)));
    CHECK(scene.link.counters().ranges_refused == 5);  // it is another sensor's
    scene.measure(down(153));
    CHECK(ok(scene.queue.pop(sample)));
}

TEST_CASE("readings are asked for while none come") {
    RangeScene scene;
    const auto requests = [&] {
        scene.link.service();
        return scene.heard(MavlinkId::kCommandLong).size();
    };
    CHECK(requests() == 0);  // there is no flight controller yet
    scene.arm(false);
    const auto asked = scene.heard(MavlinkId::kCommandLong);
    REQUIRE(asked.size() == 1);
    const MavCommand command = decode_command(asked[0]);
    CHECK(command.command == kMavCmdSetMessageInterval);
    CHECK(command.param[0] == 132.0F);
    CHECK(command.param[1] == 20'000.0F);
    CHECK(requests() == 0);
    scene.measure(down(153));
    scene.clock.advance({4'000'000'000});
    scene.arm(false);
    CHECK(requests() == 0);
    scene.clock.advance({2'000'000'000});
    scene.arm(false);
    CHECK(scene.heard(MavlinkId::kCommandLong).size() == 1);
}

TEST_CASE("without the option the message is skipped, and nothing is asked for") {
    Scene scene;
    RangeQueue queue;
    scene.link.give_ranges_to(&queue);
    scene.arm(false);
    CHECK(scene.heard(MavlinkId::kCommandLong).empty());
    CHECK(scene.link.counters().ranges_refused == 0);
}

}  // namespace
}  // namespace facet::mavlink_range_test
