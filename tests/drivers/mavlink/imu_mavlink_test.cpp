// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/imu_mavlink.h"

#include <catch2/catch.hpp>
#include <memory>

#include "tests/drivers/mavlink/fake_autopilot.h"
#include "tests/port_conformance/source_conformance.h"
#include "tests/support/allocation_guard.h"

namespace facet::imu_mavlink_test {
namespace {

constexpr Duration kPeriod{5'000'000};

/// Stamps that TIMESYNC can be wrong by here: half the difference of the delays, and what a block leaves.
constexpr double kTimeError_s = 0.3e-3;

ImuMavlinkOptions judged_mavlink() {
    ImuMavlinkOptions options;
    options.silence = Duration::from_seconds(1.0);
    return options;
}

class MavlinkImuHarness final : public test::ImuHarness {
public:
    ImuSource& source() override { return scene.imu; }
    void offer(int count) override {
        scene.learn_time();
        for (int i = 0; i < count; ++i) {
            scene.tick(kPeriod);
        }
        scene.clock.advance(kPeriod);
    }
    test::Hook offer_corrupt() override {
        scene.learn_time();
        scene.kernel.say(test::highres(scene.now_us(), {std::nan(""), 0, 0}, {0, 0, 0}), scene.options.message);
        scene.clock.advance(kPeriod);
        return test::Hook::kDone;
    }
    test::Hook offer_ahead() override {
        constexpr std::uint64_t kHour_us = 3'600'000'000;
        scene.kernel.say(test::highres(scene.now_us() + kHour_us, {0, 0, -9.8}, {0, 0, 0}), scene.options.message);
        scene.clock.advance(kPeriod);
        return test::Hook::kDone;
    }
    test::Hook break_device() override {
        scene.kernel.port_works = false;
        return test::Hook::kDone;
    }
    void repair_device() override { scene.kernel.port_works = true; }
    test::Hook judges_silence() override { return test::Hook::kDone; }
    test::Hook end() override { return test::Hook::kCannot; }
    void pass_time() override { scene.clock.advance(Duration::from_seconds(0.6)); }
    int held_back() const override { return 0; }

    static MavlinkOptions serial() {
        MavlinkOptions link;
        link.channel.serial = "/dev/ttyS1";
        return link;
    }
    test::AutopilotScene scene{judged_mavlink(), serial()};
};

TEST_CASE("the flight controller's IMU keeps the contract of its port", "[port_conformance]") {
    test::check_source_conformance<test::ImuHarness>([] { return std::make_unique<MavlinkImuHarness>(); });
}

TEST_CASE("readings of every message become SI units in the body's axes") {
    ImuMavlinkOptions options;
    options.message =
        GENERATE(MavlinkImuMessage::kHighresImu, MavlinkImuMessage::kRawImu, MavlinkImuMessage::kScaledImu,
                 MavlinkImuMessage::kScaledImu2, MavlinkImuMessage::kScaledImu3);
    CAPTURE(to_string(options.message));
    test::AutopilotScene s(options);
    REQUIRE(ok(s.imu.start()));
    s.learn_time();
    if (options.message == MavlinkImuMessage::kHighresImu) {
        s.kernel.say(test::highres(s.now_us(), {0.980665, 1.96133, -9.80665}, {0.25, 0.5, -1.0}), options.message);
    } else {
        MavlinkPayload payload;
        MavlinkWriter out(payload);
        if (options.message == MavlinkImuMessage::kRawImu) {
            out.put(s.now_us());
        } else {
            out.put(static_cast<std::uint32_t>(s.now_us() / 1000));
        }
        for (const int value : {100, 200, -1000, 250, 500, -1000, 7, 8, 9}) {
            out.put(static_cast<std::int16_t>(value));
        }
        if (options.message == MavlinkImuMessage::kRawImu) {
            out.put(std::uint8_t{0});
        }
        out.put(std::int16_t{2575});
        s.kernel.say(payload, options.message);
    }
    const Timestamp sent = s.clock.now();
    s.clock.advance(kPeriod);
    const std::vector<ImuSample> samples = s.drain();
    REQUIRE(samples.size() == 1);
    CHECK((samples[0].a_B - Eigen::Vector3d(0.980665, -1.96133, 9.80665)).norm() < 1e-6);
    CHECK((samples[0].w_B - Eigen::Vector3d(0.25, -0.5, 1.0)).norm() < 1e-6);
    const double rounding_s = options.message >= MavlinkImuMessage::kScaledImu ? 1e-3 : 1e-6;
    CHECK(std::abs((samples[0].stamp - sent).seconds()) < rounding_s + kTimeError_s);
    if (options.message == MavlinkImuMessage::kHighresImu) {
        CHECK(std::isnan(s.imu.temperature_c()));
    } else {
        CHECK(s.imu.temperature_c() == Approx(25.75));
    }
}

TEST_CASE("the message is asked for until it comes as often as it should, and again when it stops") {
    ImuMavlinkOptions options;
    options.rate_hz = 250.0;
    test::AutopilotScene s(options);
    REQUIRE(ok(s.imu.start()));
    s.learn_time();
    REQUIRE_FALSE(s.kernel.commands.empty());
    const MavCommand& command = s.kernel.commands.front();
    CHECK(command.command == 511);
    CHECK(command.param[0] == 105.0F);
    CHECK(command.param[1] == 4000.0F);
    CHECK(command.target == MavlinkAddress{1, 1});
    const auto fly = [&](double seconds, Duration period) {
        const std::size_t before = s.kernel.commands.size();
        for (const Timestamp end = s.clock.now() + Duration::from_seconds(seconds); s.clock.now() < end;) {
            s.tick(period);
            (void)s.drain();
        }
        return s.kernel.commands.size() - before;
    };
    (void)fly(2.0, {4'000'000});
    CHECK(fly(10.0, {4'000'000}) == 0);
    CHECK(s.imu.sent_rate_hz() == Approx(250.0).epsilon(0.01));
    CHECK(fly(10.0, {4'800'000}) == 0);  // 208 Hz
    (void)fly(1.0, {20'000'000});
    CHECK(fly(10.0, {20'000'000}) == 2);  // 50 Hz: too few
    s.kernel.autopilot.silent = true;
    CHECK(fly(10.0, {4'000'000}) >= 8);
}

TEST_CASE("a controller that refuses the message, or does not tell its time, is reported in words") {
    test::AutopilotScene s(judged_mavlink());
    const bool refuses = GENERATE(true, false);
    s.kernel.autopilot.answers_time = refuses;
    s.kernel.autopilot.answer = refuses ? MavResult::kDenied : MavResult::kAccepted;
    REQUIRE(ok(s.imu.start()));
    Status status = Status::kNotReady;
    for (int i = 0; i < 1000 && status != Status::kIo; ++i) {
        if (!refuses) {
            s.tick(kPeriod);
        }
        ImuSample sample;
        status = s.imu.next(Duration::from_seconds(0.01), sample);
        CHECK_FALSE(ok(status));
    }
    CHECK(status == Status::kIo);
    CHECK_THAT(std::string(s.imu.problem()),
               Catch::Contains(refuses ? "it refuses SET_MESSAGE_INTERVAL" : "TIMESYNC is not answered"));
    CHECK_THAT(std::string(s.imu.problem()), Catch::StartsWith("127.0.0.1:14580: no good data for"));
    CHECK(s.imu.counters().delivered == 0);
}

TEST_CASE("readings that come twice, late, of another sensor or by halves are left out, gaps are counted") {
    test::AutopilotScene s;
    REQUIRE(ok(s.imu.start()));
    s.learn_time();
    for (int i = 0; i < 100; ++i) {
        s.tick(kPeriod);
    }
    CHECK(s.drain().size() == 100);
    const MavlinkPayload again = test::highres(s.now_us(), {0, 0, -9.8}, {0, 0, 0});
    s.kernel.say(again, s.options.message);
    s.kernel.say(again, s.options.message, {1'000'000});
    s.clock.advance(kPeriod);
    CHECK(s.drain().size() == 1);
    CHECK(s.imu.imu_counters().duplicates == 1);
    s.tick(kPeriod, {7'000'000});  // overtaken by the next one
    s.tick(kPeriod);
    s.tick(kPeriod);
    CHECK(s.drain().size() == 2);
    CHECK(s.imu.imu_counters().duplicates == 2);
    CHECK(s.imu.counters().lost == 1);  // by the gap, until it came
    s.kernel.say(test::highres(s.now_us(), {0, 0, -9.8}, {0, 0, 0}, 0x3F, 1), s.options.message);
    s.kernel.say(test::highres(s.now_us(), {0, 0, -9.8}, {0, 0, 0}, 0x1F), s.options.message);
    s.clock.advance(kPeriod);
    CHECK(s.drain().empty());
    CHECK(s.imu.imu_counters().other_sensors == 1);
    CHECK(s.imu.imu_counters().incomplete == 1);
    s.clock.advance(Duration{9 * kPeriod.ns});
    s.tick(kPeriod);
    CHECK(s.drain().size() == 1);
    CHECK(s.imu.counters().lost == 1 + 10);
    CHECK(s.imu.counters().discarded == 3);
    CHECK(s.imu.counters().corrupt == 0);
}

TEST_CASE("another rate than the one asked for is no loss") {
    test::AutopilotScene s;
    REQUIRE(ok(s.imu.start()));
    s.learn_time();
    for (int i = 0; i < 500; ++i) {
        s.tick({10'000'000});
        (void)s.drain();
    }
    CHECK(s.imu.counters().lost < 10);
    CHECK(s.imu.sent_rate_hz() == Approx(100.0).epsilon(0.01));
}

TEST_CASE("stamps follow a clock that drifts behind a link with jitter, without steps") {
    test::AutopilotScene s;
    s.kernel.autopilot.drift = 40e-6;
    s.kernel.autopilot.jitter = {3'000'000};
    REQUIRE(ok(s.imu.start()));
    s.learn_time();
    double worst_s = 0.0;
    double worst_interval = 0.0;
    std::optional<ImuSample> last;
    int count = 0;
    for (int i = 0; i < 12'000; ++i) {  // a minute
        const Timestamp sent = s.clock.now();
        s.kernel.say(test::highres(s.now_us(), {0, 0, -9.8}, {static_cast<double>(i), 0, 0}), s.options.message);
        s.clock.advance(kPeriod);
        for (const ImuSample& sample : s.drain()) {
            ++count;
            if (last) {
                const double n = sample.w_B.x() - last->w_B.x();
                const double interval = (sample.stamp - last->stamp).seconds() / (n * kPeriod.seconds());
                worst_interval = std::max(worst_interval, std::abs(interval - 1.0));
            }
            last = sample;
        }
        if (last && i > 3000) {
            const double age_s = (sent - last->stamp).seconds() - (i - last->w_B.x()) * kPeriod.seconds();
            worst_s = std::max(worst_s, std::abs(age_s));
        }
    }
    CAPTURE(worst_s, worst_interval, count);
    CHECK(count > 95);
    CHECK(worst_s < kTimeError_s);
    CHECK(worst_interval < 1e-3);  // the slew, and microseconds
}

TEST_CASE("a controller that reboots is followed once its new time is known") {
    test::AutopilotScene s(judged_mavlink());
    REQUIRE(ok(s.imu.start()));
    s.learn_time();
    for (int i = 0; i < 200; ++i) {
        s.tick(kPeriod);
        (void)s.drain();
    }
    s.kernel.autopilot.boot_s = s.clock.now().seconds() - 0.5;
    const Timestamp rebooted = s.clock.now();
    std::optional<Timestamp> first;
    Timestamp last;
    for (int i = 0; i < 1000; ++i) {
        s.tick(kPeriod);
        for (const ImuSample& sample : s.drain()) {
            CHECK(sample.stamp > last);
            last = sample.stamp;
            first = first ? first : sample.stamp;
        }
    }
    REQUIRE(first);
    CHECK(s.imu.imu_counters().reboots == 1);
    CHECK((*first - rebooted).seconds() < 2.0);
    CHECK(std::abs((s.clock.now() - last).seconds()) < 2 * kPeriod.seconds());
    CHECK(s.imu.counters().errors == 1);
    CHECK(s.imu.counters().recoveries == 1);
}

TEST_CASE("microseconds of 32 bits restart without a gap") {
    ImuMavlinkOptions options;
    options.message = MavlinkImuMessage::kRawImu;
    test::AutopilotScene s(options);
    constexpr double kWrap_s = 4294.967296;
    s.kernel.autopilot.boot_s = s.clock.now().seconds() - 2.0 * kWrap_s + 3.0;
    REQUIRE(ok(s.imu.start()));
    s.learn_time();
    std::size_t samples = 0;
    for (int i = 0; i < 1000; ++i) {
        MavlinkPayload payload;
        MavlinkWriter out(payload);
        out.put(std::uint64_t{static_cast<std::uint32_t>(s.now_us())});
        for (const int value : {0, 0, -1000, 0, 0, 0, 0, 0, 0}) {
            out.put(static_cast<std::int16_t>(value));
        }
        s.kernel.say(payload, options.message);
        s.clock.advance(kPeriod);
        samples += s.drain().size();
    }
    CHECK(samples >= 999);
    CHECK(s.imu.counters().lost == 0);
    CHECK(s.imu.imu_counters().reboots == 0);
}

TEST_CASE("no reading is stamped later than it came, whatever the delays of the two ways") {
    test::AutopilotScene s;
    s.kernel.autopilot.up = {100'000};
    s.kernel.autopilot.down = {100'000};
    s.kernel.autopilot.answers_time = true;
    REQUIRE(ok(s.imu.start()));
    // Answers to TIMESYNC wait 8 ms before they are sent; readings do not.
    s.kernel.autopilot.down = {8'000'000};
    s.learn_time();
    REQUIRE(s.link.timesync().ready());
    s.kernel.autopilot.down = {100'000};
    s.kernel.autopilot.answers_time = false;
    std::size_t samples = 0;
    for (int i = 0; i < 200; ++i) {
        s.tick(kPeriod);
        for (const ImuSample& sample : s.drain()) {
            ++samples;
            CHECK(sample.stamp <= s.clock.now());
        }
    }
    CHECK(samples >= 199);
    CHECK(s.imu.imu_counters().stamps_refused == 0);
}

TEST_CASE("the delays of the controller's filters are taken off, each from its own readings") {
    ImuMavlinkOptions options;
    options.latency = {2'000'000};
    options.gyro_filter_hz = 40.0;
    options.accel_filter_hz = 20.0;
    CHECK(low_pass_delay(40.0).seconds() == Approx(0.0056270).epsilon(1e-4));
    CHECK(low_pass_delay(0.0).ns == 0);
    test::AutopilotScene s(options);
    REQUIRE(ok(s.imu.start()));
    s.learn_time();
    // A reading's force is its time since `begin`, its rate too: the samples show what belongs to which instant.
    const Timestamp begin = s.clock.now();
    std::vector<ImuSample> samples;
    for (int i = 0; i < 100; ++i) {
        const double t_s = (s.clock.now() - begin).seconds();
        s.kernel.say(test::highres(s.now_us(), {t_s, 0, 0}, {t_s, 0, 0}), options.message);
        s.clock.advance(kPeriod);
        const std::vector<ImuSample> more = s.drain();
        samples.insert(samples.end(), more.begin(), more.end());
    }
    REQUIRE(samples.size() > 90);
    for (const ImuSample& sample : samples) {
        const double at_s = (sample.stamp - begin).seconds();
        CHECK(std::abs(sample.w_B.x() - at_s - 0.002 - low_pass_delay(40.0).seconds()) < kTimeError_s);
        CHECK(std::abs(sample.a_B.x() - at_s - 0.002 - low_pass_delay(20.0).seconds()) < kTimeError_s);
    }
}

TEST_CASE("estimates go out by the same link, and all of it without heap") {
    test::AutopilotScene s;
    REQUIRE(ok(s.imu.start()));
    s.learn_time();
    Odometry odometry;
    odometry.quality = 80;
    CHECK(s.imu.outbox().send(odometry) == Status::kOk);
    s.imu.outbox().report({SinkState::kTracking, {}, 0});
    CHECK(s.imu.outbox().send_ranges({}) == Status::kOk);
    s.tick(kPeriod);
    CHECK(s.kernel.poses == 0);
    (void)s.drain();
    CHECK(s.kernel.poses == 1);
    for (int i = 0; i < 32; ++i) {
        CHECK(s.imu.outbox().send(odometry) == Status::kOk);
    }
    CHECK(s.imu.outbox().send(odometry) == Status::kFull);
    (void)s.drain();
    CHECK(s.kernel.poses == 33);

    s.tick(kPeriod);
    s.kernel.is_deaf = true;
    ImuSample sample;
    Status status = Status::kNotReady;
    const test::AllocationGuard guard;
    (void)s.imu.outbox().send(odometry);
    status = s.imu.next({}, sample);
    const std::uint64_t allocations = guard.allocations();
    CHECK(allocations == 0);
    CHECK(status == Status::kOk);
}

}  // namespace
}  // namespace facet::imu_mavlink_test
