// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_can/imu_can.h"

#include <linux/can/error.h>
#include <linux/net_tstamp.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/imu_can/dbc_decoder.h"
#include "drivers/imu_can/dronecan.h"
#include "drivers/imu_can/openimu300.h"
#include "tests/drivers/imu_can/fake_can_bus.h"
#include "tests/port_conformance/source_conformance.h"

namespace facet::imu_can_test {
namespace {

constexpr std::int64_t kPeriodNs = 5'000'000;
constexpr std::int64_t kHourNs = 3'600'000'000'000;
constexpr std::int64_t kEpochNs = 1'700'000'000'000'000'000;

ImuCanOptions judged_options() {
    ImuCanOptions options;
    options.silence = Duration::from_seconds(1.0);
    return options;
}

/// An OpenIMU300 on a scripted bus: force 1 ms after the rate.
class OpenImuHarness : public test::ImuHarness {
public:
    OpenImuHarness() : OpenImuHarness(judged_options()) {}
    explicit OpenImuHarness(const ImuCanOptions& options) : imu(bus, clock, decoder, options) {
        DbcFile file;
        std::string error;
        REQUIRE(ok(file.parse(openimu300_dbc(), "openimu300", error)));
        REQUIRE(ok(decoder.configure(file, openimu300_map(), error)));
    }

    void rate(std::int64_t stamp_ns, int y = 0x00) {
        bus.push(test::make_frame(0x0CF02A80, true, {0x00, 0x7D, y, 0x7D, 0x00, 0x7D, 0xFF, 0xFF}, stamp_ns));
    }
    void force(std::int64_t stamp_ns, int x = 0x00) {
        bus.push(test::make_frame(0x0CF02D80, true, {x, 0x7D, 0x00, 0x7D, 0xD5, 0x80, 0xFF, 0xFF}, stamp_ns));
    }

    ImuSource& source() override { return imu; }
    void offer(int count) override {
        for (int i = 0; i < count; ++i) {
            t_ns += kPeriodNs;
            clock.advance({kPeriodNs});
            rate(t_ns);
            force(t_ns + 1'000'000);
        }
    }
    test::Hook offer_corrupt() override {
        t_ns += kPeriodNs;
        bus.push(test::make_frame(0x0CF02A80, true, {0, 0, 0, 0xFF, 0, 0, 0, 0}, t_ns));
        force(t_ns + 1'000'000);
        return test::Hook::kDone;
    }
    test::Hook offer_ahead() override {
        rate(t_ns + kHourNs);
        force(t_ns + kHourNs + 1'000'000);
        return test::Hook::kDone;
    }
    test::Hook break_device() override {
        bus.up = false;
        bus.present = false;
        return test::Hook::kDone;
    }
    test::Hook judges_silence() override { return test::Hook::kDone; }
    test::Hook end() override { return test::Hook::kCannot; }
    void repair_device() override {
        bus.up = true;
        bus.present = true;
    }
    void pass_time() override {
        clock.advance(Duration::from_seconds(0.6));
        t_ns = clock.read_pair().realtime.ns;
    }
    int held_back() const override { return 1; }  // the first rate has no force before it

    ManualClock clock{{1'000'000'000}, {kEpochNs}};
    test::FakeCanBus bus{clock};
    DbcDecoder decoder;
    ImuCan imu;
    std::int64_t t_ns = kEpochNs;
};

TEST_CASE("the CAN IMU keeps the contract of its port", "[port_conformance]") {
    test::check_source_conformance<test::ImuHarness>([] { return std::make_unique<OpenImuHarness>(); });
}

TEST_CASE("rates and forces of different frames are put together by time") {
    ImuCanOptions options;
    REQUIRE(ok(options.axes.parse("y -x z")));
    options.latency = {500'000};
    OpenImuHarness h(options);
    REQUIRE(ok(h.imu.start()));
    h.force(kEpochNs + 0, 0);             // 0 m/s^2
    h.force(kEpochNs + 10'000'000, 100);  // 1 m/s^2
    h.rate(kEpochNs + 2'500'000, 0x80);   // y = 1 deg/s
    h.rate(kEpochNs + 10'000'000);
    ImuSample sample;
    REQUIRE(h.imu.next({}, sample) == Status::kOk);
    CHECK(sample.stamp.ns == 2'000'000);
    CHECK((sample.w_B - Eigen::Vector3d(std::numbers::pi / 180.0, 0.0, 0.0)).norm() < 1e-12);
    CHECK((sample.a_B - Eigen::Vector3d(0.0, -0.25, 9.81)).norm() < 1e-9);
    REQUIRE(h.imu.next({}, sample) == Status::kOk);
    CHECK((sample.a_B - Eigen::Vector3d(0.0, -1.0, 9.81)).norm() < 1e-9);
    CHECK(h.imu.clock() == ClockDomain::kMonotonic);
    CHECK((h.bus.stamping_flags & SOF_TIMESTAMPING_RX_HARDWARE) == 0);
}

TEST_CASE("DroneCAN samples come out through the same source") {
    ManualClock clock({0}, {kEpochNs});
    test::FakeCanBus bus(clock);
    DroneCanDecoder decoder;
    ImuCanOptions options;
    options.socket.fd = true;
    ImuCan imu(bus, clock, decoder, options);
    REQUIRE(ok(imu.start()));
    CHECK(bus.fd_enabled);
    CanFrame frame;
    frame.id = (16U << 24) | (1003U << 8) | 9U;
    frame.extended = true;
    frame.fd = true;
    frame.length = 48;
    frame.bytes[12] = 0x38;  // rate x = 0.5
    frame.bytes[47] = 0xC0;
    frame.stamp.ns = kEpochNs;
    bus.push(frame);
    ImuSample sample;
    REQUIRE(imu.next({}, sample) == Status::kOk);
    CHECK(sample.w_B.x() == 0.5);
    CHECK(sample.stamp.ns == 0);
}

TEST_CASE("only frames of the decoder pass the kernel's filter") {
    OpenImuHarness h;
    REQUIRE(ok(h.imu.start()));
    h.bus.push(test::make_frame(0x123, false, {1, 2, 3}));
    h.bus.push(test::make_frame(0x0CF02980, true, {1, 2, 3}));
    CHECK(h.bus.filtered_out == 2);
    h.offer(2);
    CHECK(h.bus.filtered_out == 2);
}

TEST_CASE("bus-off is named, counted and left behind with the first good frame") {
    OpenImuHarness h;
    REQUIRE(ok(h.imu.start()));
    h.offer(3);
    (void)test::drain(h);
    CanFrame warning;
    warning.error = true;
    warning.id = CAN_ERR_CRTL;
    warning.length = 8;
    h.bus.push(warning);
    ImuSample sample;
    CHECK(h.imu.next({}, sample) == Status::kNotReady);
    CHECK(h.imu.can_counters().error_frames == 1);
    CanFrame off = warning;
    off.id = CAN_ERR_BUSOFF;
    h.bus.push(off);
    CHECK(h.imu.next({}, sample) == Status::kIo);
    CHECK(h.imu.problem() == "can0: bus-off; the kernel restarts the controller if restart-ms is set");
    CHECK(h.imu.can_counters().bus_off == 1);
    off.id = CAN_ERR_RESTARTED;
    h.bus.push(off);
    h.offer(3);
    CHECK(test::drain(h).stamps.size() == 3);
    CHECK(h.imu.counters().errors == 1);
    CHECK(h.imu.counters().recoveries == 1);
    CHECK(h.bus.opened == 1);
}

TEST_CASE("an interface that goes down is reopened, at most once a period") {
    OpenImuHarness h;
    REQUIRE(ok(h.imu.start()));
    h.bus.up = false;
    ImuSample sample;
    CHECK(h.imu.next({}, sample) == Status::kIo);
    CHECK(h.imu.problem() == "can0: Network is down");
    CHECK_FALSE(h.bus.is_open);
    for (int i = 0; i < 10; ++i) {
        CHECK(h.imu.next({}, sample) == Status::kNotReady);
    }
    CHECK(h.bus.opened == 1);
    h.pass_time();
    h.bus.up = true;
    CHECK(h.imu.next({}, sample) == Status::kNotReady);
    CHECK(h.bus.opened == 2);
}

TEST_CASE("a missing interface is said in words") {
    OpenImuHarness h;
    h.bus.interface = "can1";
    CHECK(h.imu.start() == Status::kNotFound);
    CHECK(h.imu.problem() == "can0: no such interface: No such device");
    ImuCanOptions options;
    options.socket.interface = "an_interface_name_too_long";
    OpenImuHarness other(options);
    CHECK(other.imu.start() == Status::kInvalidArgument);
}

TEST_CASE("stamps: hardware ones if asked for and there, our own clock if the kernel gives none") {
    ImuCanOptions options;
    options.socket.hardware_stamps = true;
    OpenImuHarness h(options);
    h.bus.hardware_stamps = true;
    REQUIRE(ok(h.imu.start()));
    CHECK(h.imu.clock() == ClockDomain::kHardware);
    h.offer(2);
    ImuSample sample;
    REQUIRE(h.imu.next({}, sample) == Status::kOk);
    CHECK(sample.stamp.ns / 1'000'000'000 == 42);

    OpenImuHarness bare;
    bare.bus.stamps = false;
    REQUIRE(ok(bare.imu.start()));
    bare.force(0);
    CHECK(bare.imu.next({}, sample) == Status::kNotReady);
    bare.clock.advance({kPeriodNs});
    bare.rate(0);
    CHECK(bare.imu.next({}, sample) == Status::kNotReady);
    bare.clock.advance({kPeriodNs});
    bare.force(0);
    REQUIRE(bare.imu.next({}, sample) == Status::kOk);
    CHECK(sample.stamp.ns == 1'000'000'000 + kPeriodNs);
    CHECK(bare.imu.can_counters().unstamped == 3);
}

/// Plays samples at 200 Hz, read 2 ms after their reception; the wall clock changes by `change` at the 400th, while two
/// samples wait in the socket, and by ppm afterwards. @return the largest gap between samples and error of a stamp
std::pair<double, double> gap_and_error_s(Duration change, double ppm) {
    OpenImuHarness h;
    REQUIRE(ok(h.imu.start()));
    double gap_s = 0.0;
    double error_s = 0.0;
    Timestamp last = h.clock.now();
    Duration offset{kEpochNs};
    for (int i = 0; i < 1000; ++i) {
        offset.ns += i > 400 ? static_cast<std::int64_t>(ppm * 1e-6 * kPeriodNs) : 0;
        h.clock.set_realtime_offset(offset);
        h.clock.advance({kPeriodNs});
        const Timestamp measured = h.clock.now();
        h.rate(h.clock.read_pair().realtime.ns);
        h.force(h.clock.read_pair().realtime.ns + 1000);
        if (i == 400 || i == 401) {
            offset.ns += i == 401 ? change.ns : 0;
            continue;  // the reader was away
        }
        h.clock.set_realtime_offset(offset);
        h.clock.advance({2'000'000});
        ImuSample sample;
        while (ok(h.imu.next({}, sample))) {
            gap_s = std::max(gap_s, (sample.stamp - last).seconds());
            last = sample.stamp;
            if (i < 400 || i > 403) {
                error_s = std::max(error_s, std::abs((sample.stamp - measured).seconds()));
            }
        }
        h.clock.advance({-2'000'000});
    }
    CHECK((h.clock.now() - last).seconds() < 0.02);
    return {gap_s, error_s};
}

TEST_CASE(
    "steps of the wall clock cost the samples that waited, whichever way and however far; slewing costs nothing") {
    for (const double step_s : {30.0, 3600.0, -10.0, -0.5, 0.05, 0.0}) {
        CAPTURE(step_s);
        const auto [gap_s, error_s] = gap_and_error_s(Duration::from_seconds(step_s), 0.0);
        CHECK(gap_s < 0.03);
        CHECK(error_s < 20e-6);
    }
    const auto [gap_s, error_s] = gap_and_error_s({}, 500.0);
    CHECK(gap_s < 0.03);
    CHECK(error_s < 20e-6);
}

TEST_CASE("frames of impossible size and full sockets are counted") {
    OpenImuHarness h;
    REQUIRE(ok(h.imu.start()));
    h.bus.odd_size = true;
    h.bus.overflows = 17;
    h.offer(3);
    const test::Drained all = test::drain(h);
    CHECK(all.corrupt == 1);
    CHECK(h.imu.can_counters().overflows == 17);
}

TEST_CASE("waiting lasts as long as asked and no longer") {
    OpenImuHarness h;
    REQUIRE(ok(h.imu.start()));
    const Timestamp before = h.clock.now();
    ImuSample sample;
    CHECK(h.imu.next(Duration::from_seconds(0.02), sample) == Status::kNotReady);
    CHECK(h.clock.now() - before == Duration::from_seconds(0.02));
}

}  // namespace
}  // namespace facet::imu_can_test
