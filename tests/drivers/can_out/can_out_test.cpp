// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/can_out/can_out.h"

#include <linux/can/error.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "drivers/can_out/node_status.h"
#include "tests/drivers/imu_can/fake_can_bus.h"
#include "tests/support/allocation_guard.h"

namespace facet::can_out_test {
namespace {

constexpr std::uint32_t kFirst = 0x3A0;
constexpr std::uint32_t kFdId = kFirst + 1;

/// A sink on a scripted bus, at 10 s past the start of the computer.
struct Scene {
    explicit Scene(CanOutOptions options = {}) : out(bus, clock, std::move(options)) {}
    void open() {
        std::string problem;
        REQUIRE(ok(out.open(problem)));
    }
    Status send(std::uint8_t resets = 0, int quality = 80) {
        Odometry odometry;
        odometry.stamp = clock.now() - Duration::from_seconds(0.02);
        odometry.quality = quality;
        odometry.reset_counter = resets;
        odometry.state = quality < 0 ? SinkState::kLost : SinkState::kTracking;
        return out.send(odometry);
    }
    /// Lets time pass as the sinks' thread does.
    void pass(double span_s) {
        for (int i = 0; i < static_cast<int>(span_s * 100.0 + 0.5); ++i) {
            clock.advance(Duration::from_seconds(0.01));
            out.service();
        }
    }
    void push_error(std::uint32_t error_class) {
        CanFrame frame;
        frame.error = true;
        frame.id = error_class;
        frame.length = 8;
        bus.push(frame);
    }
    std::size_t count(std::uint32_t id) const {
        return static_cast<std::size_t>(
            std::count_if(bus.sent.begin(), bus.sent.end(), [&](const CanFrame& frame) { return frame.id == id; }));
    }

    ManualClock clock{{10'000'000'000}};
    test::FakeCanBus bus{clock};
    CanOut out;
};

TEST_CASE("an estimate is one frame on CAN FD, nine on a classic bus") {
    Scene scene;
    SECTION("FD where the interface is set up for it") {
        scene.bus.takes_fd = true;
        scene.open();
        CHECK(scene.out.name() == "can0, CAN FD");
        CHECK(ok(scene.send()));
        REQUIRE(scene.bus.sent.size() == 1);
        CHECK(scene.bus.sent[0].id == kFdId);
        CHECK(scene.bus.sent[0].fd);
        CHECK(scene.bus.sent[0].bit_rate_switch);
        CHECK(scene.bus.sent[0].length == 64);
    }
    SECTION("classic elsewhere") {
        scene.open();
        CHECK(scene.out.name() == "can0, classic CAN");
        CHECK(ok(scene.send()));
        REQUIRE(scene.bus.sent.size() == kClassicFrames);
        for (std::size_t i = 0; i < kClassicFrames; ++i) {
            CHECK(scene.bus.sent[i].id == kFirst + 2 + i);
            CHECK_FALSE(scene.bus.sent[i].fd);
            CHECK(scene.bus.sent[i].bytes[0] == 0);
        }
        CHECK(ok(scene.send()));
        CHECK(scene.bus.sent.back().bytes[0] == 1);  // the count that joins the frames of one estimate
    }
    CHECK(scene.out.counters().estimates_dropped == 0);
}

TEST_CASE("the format can be chosen") {
    Scene classic({.format = CanOutFormat::kClassic});
    classic.bus.takes_fd = true;
    classic.open();
    CHECK_FALSE(classic.bus.fd_enabled);
    CHECK(ok(classic.send()));
    CHECK(classic.bus.sent.size() == kClassicFrames);
    Scene fd({.format = CanOutFormat::kFd, .bit_rate_switch = false});
    fd.open();
    CHECK(ok(fd.send()));
    REQUIRE(fd.bus.sent.size() == 1);
    CHECK_FALSE(fd.bus.sent[0].bit_rate_switch);
}

TEST_CASE("an interface that is not there is named") {
    Scene scene({.interface = "can7"});
    std::string problem;
    CHECK(scene.out.open(problem) == Status::kNotFound);
    CHECK(problem.starts_with("can7: no such interface"));
}

TEST_CASE("the frames of others do not reach the socket") {
    Scene scene;
    scene.open();
    scene.bus.push(test::make_frame(0x123, false, {1, 2, 3}));
    CHECK(scene.bus.filtered_out == 1);
}

TEST_CASE("health goes out ten times a second from the start, and at once when the state changes") {
    Scene scene;
    scene.open();
    scene.pass(1.0);
    CHECK(scene.count(kFirst) == 10);
    CHECK(scene.bus.sent.back().bytes[7] == 255);  // no estimate yet
    CHECK((scene.bus.sent.back().bytes[0] & 0x0F) == 0);
    CHECK(ok(scene.send(3)));
    scene.clock.advance(Duration::from_seconds(0.01));
    scene.out.report({.state = SinkState::kDegraded, .text = {}, .reasons = 0x020104});
    scene.out.service();
    const CanFrame& health = scene.bus.sent.back();
    REQUIRE(health.id == kFirst);
    CHECK((health.bytes[0] & 0x0F) == 2);
    CHECK(health.bytes[1] == 80);
    CHECK(health.bytes[2] == 3);
    CHECK(health.bytes[3] == 0x04);
    CHECK(health.bytes[4] == 0x01);
    CHECK(health.bytes[5] == 0x02);
    CHECK(health.bytes[7] == 3);  // 30 ms
}

TEST_CASE("poses of a lost estimator are held back unless they are requested") {
    Scene scene;
    scene.open();
    CHECK(ok(scene.send(0, -1)));
    CHECK(scene.bus.sent.empty());
    CHECK(scene.out.counters().lost_poses == 1);
    scene.pass(0.01);
    REQUIRE(scene.bus.sent.size() == 1);
    CHECK((scene.bus.sent[0].bytes[0] & 0x0F) == 3);  // but health says so
    CHECK(scene.bus.sent[0].bytes[1] == 0xFF);
    Scene wanted({.send_lost = true});
    wanted.open();
    CHECK(ok(wanted.send(0, -1)));
    CHECK(wanted.bus.sent.size() == kClassicFrames);
}

TEST_CASE("the reset counter goes on from that of the run before") {
    Scene scene;
    scene.open();
    scene.out.begin_resets_at(9);
    CHECK(scene.out.sent_resets() == 9);
    CHECK(ok(scene.send(2)));
    CHECK(scene.out.sent_resets() == 11);
    CHECK(scene.bus.sent[2].bytes[5] == 11);
}

TEST_CASE("one of so many estimates is sent") {
    Scene scene({.every = 3});
    scene.open();
    for (int i = 0; i < 9; ++i) {
        CHECK(ok(scene.send()));
    }
    CHECK(scene.out.counters().estimates == 3);
}

TEST_CASE("a full queue drops the rest of an estimate, and is counted") {
    Scene scene;
    scene.open();
    scene.bus.room = 4;
    CHECK(scene.send() == Status::kFull);
    CHECK(scene.bus.sent.size() == 4);
    CHECK(scene.out.counters().queue_full == 1);
    CHECK(scene.out.counters().estimates_dropped == 1);
    CHECK(scene.out.counters().frames == 4);
    scene.bus.room = 100;
    CHECK(ok(scene.send()));
    CHECK(scene.bus.sent.back().bytes[0] == 1);  // receivers can tell the two apart
    CHECK(scene.out.counters().estimates == 1);
}

TEST_CASE("off the bus nothing is sent until the controller is back") {
    Scene scene;
    scene.open();
    scene.push_error(CAN_ERR_BUSOFF);
    scene.pass(0.02);
    CHECK(scene.out.counters().bus_off == 1);
    const std::size_t before = scene.bus.sent.size();
    CHECK(scene.send() == Status::kFull);
    scene.pass(0.3);
    CHECK(scene.bus.sent.size() == before);
    scene.push_error(CAN_ERR_RESTARTED);
    scene.pass(0.02);
    CHECK(ok(scene.send()));
    CHECK(scene.bus.sent.size() >= before + kClassicFrames);
    CHECK(scene.out.counters().estimates_dropped == 1);
    // Twice: and the news of the return is lost.
    scene.push_error(CAN_ERR_BUSOFF);
    scene.pass(0.02);
    CHECK(scene.out.counters().bus_off == 2);
    CHECK(scene.send() == Status::kFull);
    scene.pass(1.1);
    CHECK(ok(scene.send()));
}

TEST_CASE("an interface that goes down is reopened once it is up") {
    Scene scene;
    scene.open();
    scene.bus.up = false;
    scene.pass(0.02);
    CHECK(scene.out.counters().failures == 1);
    CHECK(scene.send() == Status::kFull);
    scene.pass(3.0);
    CHECK(scene.bus.sent.empty());
    scene.bus.up = true;
    scene.pass(1.1);
    CHECK(ok(scene.send()));
    CHECK(scene.bus.sent.size() > kClassicFrames);
}

TEST_CASE("a DroneCAN node says once a second that it is alive") {
    Scene scene({.node_id = 42});
    scene.open();
    scene.pass(2.9);
    const std::uint32_t id = (24U << 24) | (341U << 8) | 42U;
    CHECK(scene.count(id) == 3);
    const auto last = std::find_if(scene.bus.sent.rbegin(), scene.bus.sent.rend(),
                                   [&](const CanFrame& frame) { return frame.id == id; });
    REQUIRE(last != scene.bus.sent.rend());
    CHECK(last->extended);
    CHECK(last->bytes[0] == 2);              // seconds
    CHECK((last->bytes[7] & 0x1F) == 2);     // the third transfer
    CHECK((last->bytes[4] & 0x38) == 0x08);  // INITIALIZATION: no estimate yet
    Scene none;
    none.open();
    none.pass(3.0);
    CHECK(none.count(id) == 0);
}

TEST_CASE("what is no estimate is refused, and costs the bus nothing") {
    Scene scene;
    scene.open();
    Odometry odometry;
    odometry.p_W_B.x() = std::numeric_limits<double>::quiet_NaN();
    CHECK(scene.out.send(odometry) == Status::kInvalidArgument);
    CHECK(scene.bus.sent.empty());
    CHECK(scene.out.counters().estimates_dropped == 0);
}

TEST_CASE("sending uses no heap") {
    Scene scene({.node_id = 7});
    scene.open();
    scene.bus.sent.reserve(1000);
    const test::AllocationGuard guard;
    for (int i = 0; i < 20; ++i) {
        (void)scene.send();
        scene.pass(0.02);
    }
    CHECK(guard.allocations() == 0);
}

}  // namespace
}  // namespace facet::can_out_test
