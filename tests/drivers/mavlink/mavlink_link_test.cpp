// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_link.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/drivers/mavlink/link_scene.h"
#include "tests/support/allocation_guard.h"

namespace facet::mavlink_link_test {
namespace {

using test::Bytes;
using test::example;
using test::FakeUdp;
using test::Scene;

std::uint64_t time_us(const MavlinkPacket& packet) {
    return MavlinkReader({packet.payload.data(), packet.payload.size()}).take<std::uint64_t>();
}

MavCommand command_of(std::uint16_t number, float param1 = 0.0F) {
    MavCommand command{.command = number, .target = {1, 197}};
    command.param[0] = param1;
    return command;
}

/// A serial line that takes a few bytes at a time, and now and then none.
class NarrowLine final : public test::FakeKernel {
public:
    int open(const char*, int) override { return 5; }
    int close(int) override { return 0; }
    int ioctl(int, unsigned long, void*) override { return 0; }
    std::int64_t read(int, void*, std::size_t) override { return -EAGAIN; }
    std::int64_t write(int, const void* buffer, std::size_t size) override {
        const std::size_t taken = std::min(size, room);
        if (taken == 0) {
            return -EAGAIN;
        }
        room -= taken;
        const auto* bytes = static_cast<const std::uint8_t*>(buffer);
        sent.insert(sent.end(), bytes, bytes + taken);
        return static_cast<std::int64_t>(taken);
    }
    std::size_t room = 0;
    Bytes sent;
};

TEST_CASE("a serial line that is full cuts no frame: what it has begun it gets whole, before anything else") {
    ManualClock clock{{100'000'000'000}};
    NarrowLine kernel;
    MavlinkOptions options;
    options.channel.serial = "/dev/ttyS9";
    MavlinkLink link(kernel, clock, options);
    std::string problem;
    REQUIRE(link.open(problem) == Status::kOk);
    MavlinkParser parser;
    MavlinkPacket packet;
    std::span<const std::uint8_t> raw;
    std::uint64_t parsed = 0;
    Odometry pose = example();
    for (int i = 0; i < 400; ++i) {
        clock.advance(Duration::from_seconds(0.01));
        pose.stamp = clock.now();
        kernel.room = static_cast<std::size_t>(i * 37 % 150);  // less than a pose needs, on average
        (void)link.send(pose);
        link.service();
        (void)parser.feed(kernel.sent);
        kernel.sent.clear();
        while (ok(parser.next(packet, raw))) {
            ++parsed;
        }
    }
    CHECK(link.counters().dropped > 50);
    CHECK(parsed > 100);
    CHECK(parser.counters().skipped == 0);
    CHECK(parser.counters().corrupt == 0);
    CHECK(parsed + 1 >= link.counters().sent);
}

TEST_CASE("an autopilot that speaks version 1 is noticed") {
    Scene scene;
    CHECK_FALSE(scene.link.hears_version_1());
    Bytes frame{0xFE, 9, 0, 1, 1, 0, 0, 0, 0, 0, 2, 3, 0x81, 3, 3};
    const std::uint8_t extra = find_mavlink_message(0)->crc_extra;
    const std::uint16_t crc = mavlink_crc(std::span(&extra, 1), mavlink_crc(std::span(frame).subspan(1)));
    frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
    scene.kernel.arriving.push_back(frame);
    scene.link.service();
    CHECK(scene.link.hears_version_1());
    CHECK(scene.link.arming() == Arming::kUnknown);
}

TEST_CASE("odometry goes out with a heartbeat a second, sequence numbers and without heap") {
    MavlinkOptions options;
    options.time = MavlinkTime::kStamps;
    options.channel.udp_local_port = 14550;
    Scene scene(options);
    CHECK(scene.kernel.port == 14580);
    CHECK(scene.kernel.local_port == 14550);
    scene.kernel.sent.reserve(100);
    for (int i = 0; i < 40; ++i) {
        REQUIRE(scene.link.send(example()) == Status::kOk);
        scene.clock.advance({50'000'000});
    }
    const std::vector<Bytes>& sent = scene.kernel.sent;
    CHECK(sent.size() == 42);
    CHECK(std::count_if(sent.begin(), sent.end(), [](const Bytes& b) { return b[7] == 0; }) == 2);
    for (std::size_t i = 1; i < sent.size(); ++i) {
        CHECK(sent[i][4] == static_cast<std::uint8_t>(sent[i - 1][4] + 1));
    }
    scene.kernel.result = -EAGAIN;
    const test::AllocationGuard guard;
    const Status full = scene.link.send(example());
    scene.link.service();
    const auto allocations = guard.allocations();
    CHECK(full == Status::kFull);
    CHECK(allocations == 0);
    CHECK(scene.link.counters().dropped >= 1);
    scene.kernel.result = -ECONNREFUSED;
    CHECK(scene.link.send(example()) == Status::kIo);
    scene.link.close();
    CHECK(scene.kernel.opened == 0);
    CHECK(scene.link.send(example()) == Status::kIo);
}

TEST_CASE("heartbeats come from the start, without any pose, and say in which state the estimator is") {
    Scene scene;
    scene.link.service();
    const auto first = scene.heard(MavlinkId::kHeartbeat);
    REQUIRE(first.size() == 1);
    CHECK(first[0].from == MavlinkAddress{1, 197});
    CHECK(decode_heartbeat(first[0].payload).system_status == kMavStateCalibrating);
    CHECK(decode_heartbeat(first[0].payload).type == 18);
    for (const auto& [state, mav] :
         {std::pair{SinkState::kTracking, kMavStateActive}, std::pair{SinkState::kDegraded, kMavStateActive},
          std::pair{SinkState::kLost, kMavStateCritical}}) {
        scene.link.report({.state = state});
        scene.clock.advance(Duration::from_seconds(1.0));
        scene.link.service();
        const auto next = scene.heard(MavlinkId::kHeartbeat);
        REQUIRE(next.size() == 1);
        CHECK(decode_heartbeat(next[0].payload).system_status == mav);
    }
}

TEST_CASE("a change of state is a text; of changes in quick succession the last one is sent") {
    Scene scene;
    const auto change = [](SinkState state, const char* text) {
        StateChange c{.state = state};
        std::strncpy(c.text.data(), text, c.text.size() - 1);
        return c;
    };
    scene.link.report(change(SinkState::kTracking, "facet: TRACKING"));
    scene.link.report(change(SinkState::kDegraded, "facet: DEGRADED few_features"));
    scene.link.report(change(SinkState::kLost, "facet: LOST no_images"));
    auto texts = scene.heard(MavlinkId::kStatusText);
    REQUIRE(texts.size() == 1);
    CHECK(texts[0].payload[0] == 6);
    scene.clock.advance(Duration::from_seconds(0.6));
    scene.link.service();
    texts = scene.heard(MavlinkId::kStatusText);
    REQUIRE(texts.size() == 1);
    CHECK(texts[0].payload[0] == 2);
    CHECK(std::string(reinterpret_cast<const char*>(texts[0].payload.data() + 1)) == "facet: LOST no_images");
    scene.clock.advance(Duration::from_seconds(5.0));
    scene.link.service();
    CHECK(scene.heard(MavlinkId::kStatusText).empty());
}

TEST_CASE("poses of a lost estimator are held back, unless they are asked for") {
    Odometry lost = example();
    lost.quality = -1;
    Scene scene;
    CHECK(scene.link.send(lost) == Status::kOk);
    CHECK(scene.heard(MavlinkId::kOdometry).empty());
    CHECK(scene.link.counters().lost_poses == 1);
    MavlinkOptions options;
    options.send_lost = true;
    Scene open(options);
    CHECK(open.pose(lost).payload[232] == 0xFF);
}

TEST_CASE("a program that restarts counts resets on from the one before, and says where it is") {
    constexpr std::size_t kResetCounter = 230;
    Scene before;
    CHECK(before.link.sent_resets() == 0);
    CHECK(before.pose(example()).payload[kResetCounter] == 5);
    CHECK(before.link.sent_resets() == 5);
    // GIVEN the watchdog's restart: the estimator counts from zero again
    Scene after;
    after.link.begin_resets_at(static_cast<std::uint8_t>(before.link.sent_resets() + 1));
    Odometry first = example();
    first.reset_counter = 0;
    CHECK(after.pose(first).payload[kResetCounter] == 6);
    first.reset_counter = 251;
    CHECK(after.pose(first).payload[kResetCounter] == 1);
    CHECK(after.link.sent_resets() == 1);
}

TEST_CASE("with the map's frame poses go out in the map of places, a jump of it as a reset") {
    constexpr std::size_t kResetCounter = 230;
    constexpr std::size_t kX = 8;
    const auto x_of = [](const auto& frame) {
        float x = 0.0F;
        std::memcpy(&x, &frame.payload[kX], sizeof(x));
        return x;
    };
    Odometry pose = example();
    pose.is_in_map = true;
    pose.map_p = {10.0, 0.0, 0.0};
    Scene odom;
    CHECK(x_of(odom.pose(pose)) == 1.0F);
    MavlinkOptions options;
    options.in_map = true;
    Scene map(options);
    const auto sent = map.pose(pose);
    CHECK(x_of(sent) == 11.0F);
    CHECK(sent.payload[kResetCounter] == 6);
    CHECK(map.link.sent_resets() == 6);
}

TEST_CASE("for older firmware the pose goes out as two messages") {
    MavlinkOptions options;
    options.message = PoseMessage::kVision;
    Scene scene(options);
    REQUIRE(scene.link.send(example()) == Status::kOk);
    const std::vector<Bytes> sent = scene.kernel.sent;
    CHECK(scene.heard(MavlinkId::kVisionPositionEstimate).size() == 1);
    scene.kernel.sent = sent;
    CHECK(scene.heard(MavlinkId::kVisionSpeedEstimate).size() == 1);
    scene.kernel.sent = sent;
    CHECK(scene.heard(MavlinkId::kOdometry).empty());
}

TEST_CASE("once synchronised, stamps and answers are in the flight controller's time; before, there is no answer") {
    constexpr Duration kAhead{-90'000'000'000};
    Scene scene;
    Odometry o = example();
    o.stamp = scene.clock.now();
    CHECK(time_us(scene.pose(o)) == static_cast<std::uint64_t>(o.stamp.ns / 1000));
    scene.say(MavTimesync{0, 77, {0, 0}});
    scene.link.service();
    const auto unanswered = scene.heard(MavlinkId::kTimesync);
    CHECK(std::all_of(unanswered.begin(), unanswered.end(),
                      [](const MavlinkPacket& p) { return decode_timesync(p.payload).tc1_ns == 0; }));
    // The answers are read only when the next service comes: the arrival is what counts.
    for (std::size_t i = 0; i < TimesyncFilter::kBlock + 2; ++i) {
        scene.link.service();
        const auto questions = scene.heard(MavlinkId::kTimesync);
        for (const MavlinkPacket& question : questions) {
            const MavTimesync asked = decode_timesync(question.payload);
            scene.clock.advance({1'000'000});
            const std::int64_t theirs = (scene.clock.now() + kAhead).ns;
            scene.clock.advance({1'000'000});
            scene.say(MavTimesync{theirs, asked.ts1_ns, {1, 197}});
            scene.link.service();
        }
        scene.clock.advance({98'000'000});
    }
    REQUIRE(scene.link.timesync().ready());
    o.stamp = scene.clock.now();
    const double stamp_s = static_cast<double>(time_us(scene.pose(o))) * 1e-6;
    CHECK(stamp_s == Approx((o.stamp + kAhead).seconds()).margin(1e-3));
    scene.say(MavTimesync{0, 77, {0, 0}});
    scene.link.service();
    bool answered = false;
    for (const MavlinkPacket& packet : scene.heard(MavlinkId::kTimesync)) {
        const MavTimesync answer = decode_timesync(packet.payload);
        if (answer.tc1_ns != 0) {
            answered = true;
            CHECK(answer.ts1_ns == 77);
            CHECK(answer.target == MavlinkAddress{0, 0});
            CHECK(static_cast<double>(answer.tc1_ns) * 1e-9 ==
                  Approx((scene.clock.now() + kAhead).seconds()).margin(1e-3));
        }
    }
    CHECK(answered);
}

TEST_CASE("answers to others, from others, or to nothing are not used") {
    Scene scene;
    scene.link.service();
    const auto questions = scene.heard(MavlinkId::kTimesync);
    REQUIRE(questions.size() == 1);
    const std::int64_t asked = decode_timesync(questions[0].payload).ts1_ns;
    for (std::size_t i = 0; i < TimesyncFilter::kBlock; ++i) {
        scene.say(MavTimesync{5, asked + 1, {1, 197}});      // not asked
        scene.say(MavTimesync{5, asked, {1, 191}});          // another component's
        scene.say(MavTimesync{5, asked, {1, 197}}, {2, 1});  // another vehicle
        scene.link.service();
    }
    CHECK_FALSE(scene.link.timesync().ready());
    // Had they been used, their bounds would contradict each other: a step.
    CHECK(scene.link.timesync().steps() == 0);
}

TEST_CASE("with our own time, questions are answered at once and none is asked") {
    MavlinkOptions options;
    options.time = MavlinkTime::kOwn;
    Scene scene(options);
    scene.say(MavTimesync{0, 1'234, {1, 197}});
    scene.link.service();
    const auto answers = scene.heard(MavlinkId::kTimesync);
    REQUIRE(answers.size() == 1);
    CHECK(decode_timesync(answers[0].payload).tc1_ns == scene.clock.now().ns);
    CHECK(decode_timesync(answers[0].payload).ts1_ns == 1'234);
    CHECK(decode_timesync(answers[0].payload).target == MavlinkAddress{1, 1});
}

TEST_CASE("arming comes from the flight controller's heartbeat, and is unknown when that stays away") {
    Scene scene;
    CHECK(scene.link.arming() == Arming::kUnknown);
    scene.arm(true);
    CHECK(scene.link.arming() == Arming::kArmed);
    scene.arm(false);
    CHECK(scene.link.arming() == Arming::kDisarmed);
    scene.say(MavHeartbeat{.type = 6, .autopilot = 8, .base_mode = 0x80}, {1, 190});  // a ground station
    scene.say(MavHeartbeat{.type = 2, .autopilot = 12, .base_mode = 0x80}, {2, 1});   // another vehicle
    scene.link.service();
    CHECK(scene.link.arming() == Arming::kDisarmed);
    scene.clock.advance(Duration::from_seconds(6.0));
    scene.link.service();
    CHECK(scene.link.arming() == Arming::kUnknown);
}

TEST_CASE("a flight controller is sent an origin from its first heartbeat until it reports one") {
    MavlinkOptions options;
    options.origin = GlobalOrigin{47.3977419, -8.5455938, 488.25};
    Scene scene(options);
    const auto origins_in = [&](int seconds) {
        std::size_t count = 0;
        for (int i = 0; i < 4 * seconds; ++i) {
            scene.arm(false);
            count += scene.heard(MavlinkId::kSetGpsGlobalOrigin).size();
            scene.clock.advance(Duration::from_seconds(0.25));
        }
        return count;
    };
    scene.link.service();
    CHECK(scene.heard(MavlinkId::kSetGpsGlobalOrigin).empty());  // nobody is there
    scene.arm(false);
    const auto sent = scene.heard(MavlinkId::kSetGpsGlobalOrigin);
    REQUIRE(sent.size() == 1);
    MavlinkReader in({sent[0].payload.data(), sent[0].payload.size()});
    CHECK(in.take<std::int32_t>() == 473'977'419);
    CHECK(in.take<std::int32_t>() == -85'455'938);
    CHECK(in.take<std::int32_t>() == 488'250);
    CHECK(in.take<std::uint8_t>() == 1);
    scene.clock.advance(Duration::from_seconds(1.0));
    CHECK(origins_in(3) == 3);
    MavlinkPayload report;
    report.resize(20);
    scene.say(MavlinkId::kGpsGlobalOrigin, report, {2, 1});  // another vehicle's
    CHECK(origins_in(2) == 2);
    scene.say(MavlinkId::kGpsGlobalOrigin, report);
    CHECK(origins_in(3) == 0);
    scene.clock.advance(Duration::from_seconds(6.0));
    scene.link.service();  // it has gone, and may come back without what it knew
    CHECK(origins_in(2) == 2);
    Scene usual;
    usual.arm(false);
    CHECK(usual.heard(MavlinkId::kSetGpsGlobalOrigin).empty());
}

TEST_CASE("commands are obeyed from the configured system only, and answered") {
    MavlinkOptions options;
    options.commands_from = 255;
    Scene scene(options);
    CHECK(scene.command(command_of(kMavCmdUser1), {254, 190}) == 2);
    CHECK_FALSE(scene.link.take_reset_request());
    CHECK(scene.command(command_of(kMavCmdUser1)) == 0);
    CHECK(scene.link.take_reset_request());
    CHECK_FALSE(scene.link.take_reset_request());
    CHECK(scene.command(command_of(400)) == 3);
    CHECK(scene.command(command_of(kMavCmdUser1), {255, 190}, MavlinkId::kCommandInt) == 7);
    MavCommand other = command_of(kMavCmdUser1);
    other.target = {1, 1};  // for the flight controller
    CHECK(scene.command(other) == -1);
    other.target = {0, 0};  // for all: not meant for us
    CHECK(scene.command(other) == -1);
    CHECK_FALSE(scene.link.take_reset_request());
    CHECK(scene.link.counters().commands == 1);
    CHECK(scene.link.counters().commands_refused == 3);
    Scene deaf;
    CHECK(deaf.command(command_of(kMavCmdUser1)) == 2);
    CHECK_FALSE(deaf.link.take_reset_request());
}

TEST_CASE("home and heading step the local frame, on the ground only, and raise the reset counter") {
    MavlinkOptions options;
    options.commands_from = 255;
    Scene scene(options);
    const auto position = [](const MavlinkPacket& packet) {
        MavlinkReader in({packet.payload.data(), packet.payload.size()});
        (void)in.take<std::uint64_t>();
        const float x = in.take_float();
        const float y = in.take_float();
        return Eigen::Vector3f(x, y, in.take_float());
    };
    const MavlinkPacket before = scene.pose(example());
    CHECK(position(before) == Eigen::Vector3f(1, -2, -3));
    CHECK(before.payload[230] == 5);
    CHECK(scene.command(command_of(kMavCmdDoSetHome, 1.0F)) == 1);  // armed or not: unknown
    scene.arm(true);
    CHECK(scene.command(command_of(kMavCmdDoSetHome, 1.0F)) == 1);
    CHECK(scene.command(command_of(kMavCmdUser2, 90.0F)) == 1);
    CHECK(scene.pose(example()).payload[230] == 5);
    scene.arm(false);
    CHECK(scene.command(command_of(kMavCmdDoSetHome, 0.0F)) == 2);  // a place on the earth
    CHECK(scene.command(command_of(kMavCmdUser2, std::numeric_limits<float>::quiet_NaN())) == 2);
    CHECK(scene.command(command_of(kMavCmdDoSetHome, 1.0F)) == 0);
    MavlinkPacket pose = scene.pose(example());
    CHECK(position(pose).norm() < 1e-6F);
    CHECK(pose.payload[230] == 6);
    CHECK(scene.command(command_of(kMavCmdUser2, 90.0F)) == 0);
    Odometry ahead = example();
    ahead.p_W_B.x() += 2.0;
    pose = scene.pose(ahead);
    CHECK((position(pose) - Eigen::Vector3f(0, 2, 0)).norm() < 1e-6F);
    CHECK(pose.payload[230] == 7);
}

TEST_CASE("with a key, frames go out signed, and only signed ones are believed") {
    MavlinkOptions options;
    options.signing = MavlinkSigningOptions{.key = {9, 8, 7}, .link = 3};
    Scene scene(options);
    scene.clock.set_realtime_offset(Duration{1'700'000'000'000'000'000});
    scene.arm(true);
    CHECK(scene.link.arming() == Arming::kUnknown);
    CHECK(scene.link.counters().signature_faults == 1);
    MavlinkSigner theirs({9, 8, 7}, 0);
    MavlinkPayload payload;
    encode(MavHeartbeat{.type = 2, .autopilot = 12, .base_mode = 0x80}, payload);
    MavlinkFrame frame;
    pack_mavlink(MavlinkId::kHeartbeat, {payload.data(), payload.size()}, {1, 1}, 9, frame);
    theirs.sign(frame, scene.clock.read_pair().realtime);
    scene.kernel.arriving.emplace_back(frame.begin(), frame.end());
    scene.link.service();
    CHECK(scene.link.arming() == Arming::kArmed);
    scene.kernel.arriving.emplace_back(frame.begin(), frame.end());  // played back
    scene.link.service();
    CHECK(scene.link.counters().signature_faults == 2);
    REQUIRE_FALSE(scene.kernel.sent.empty());
    const Bytes& ours = scene.kernel.sent.back();
    CHECK(theirs.verify(ours, scene.clock.read_pair().realtime) == Status::kOk);
    options.signing->accept_unsigned = true;
    Scene lenient(options);
    lenient.arm(true);
    CHECK(lenient.link.arming() == Arming::kArmed);
}

TEST_CASE("refuses an invalid address with the reason") {
    ManualClock clock;
    FakeUdp kernel;
    MavlinkOptions options;
    options.channel.udp_host = "autopilot";
    MavlinkLink link(kernel, clock, options);
    std::string problem;
    CHECK(link.open(problem) == Status::kInvalidArgument);
    CHECK(problem == "mavlink: 'autopilot:14580' is not an IPv4 address and port");
}

TEST_CASE("a port that could not be opened is tried again, unless its address is a mistake") {
    ManualClock clock({100'000'000'000});
    test::FakeUdp kernel;
    kernel.refusal = -ENETDOWN;
    MavlinkLink link(kernel, clock, {});
    std::string problem;
    CHECK(link.open(problem) == Status::kIo);
    link.service();
    CHECK(kernel.opened == 1);
    kernel.refusal = 0;
    clock.advance(Duration::from_seconds(1.1));
    link.service();
    CHECK(link.is_open());
    CHECK_FALSE(kernel.sent.empty());
    link.close();
    clock.advance(Duration::from_seconds(1.1));
    link.service();
    CHECK_FALSE(link.is_open());
    MavlinkOptions wrong;
    wrong.channel.udp_host = "nowhere";
    MavlinkLink mistaken(kernel, clock, wrong);
    CHECK(mistaken.open(problem) == Status::kInvalidArgument);
    const int before = kernel.opened;
    clock.advance(Duration::from_seconds(1.1));
    mistaken.service();
    CHECK(kernel.opened == before);
}

}  // namespace
}  // namespace facet::mavlink_link_test
