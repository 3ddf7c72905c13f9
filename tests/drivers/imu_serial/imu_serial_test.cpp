// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_serial/imu_serial.h"

#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <random>

#include "platform/linux/linux_clock.h"
#include "platform/linux/linux_kernel_io.h"
#include "tests/drivers/imu_serial/serial_packets.h"
#include "tests/port_conformance/source_conformance.h"

namespace facet::imu_serial_test {
namespace {

using test::SerialBytes;

constexpr std::int64_t kPeriodNs = 5'000'000;
constexpr SerialSensor kSensors[] = {SerialSensor::kVectorNav, SerialSensor::kXsens, SerialSensor::kMicroStrain};

/// A sensor on a scripted line.
class SerialHarness final : public test::ImuHarness {
public:
    explicit SerialHarness(SerialSensor sensor) : sensor_(sensor), imu(line, clock, options_of(sensor)) {}

    ImuSource& source() override { return imu; }
    void offer(int count) override {
        for (int i = 0; i < count; ++i) {
            line.arrive(next_packet());
        }
    }
    test::Hook offer_corrupt() override {
        SerialBytes bytes = next_packet();
        bytes[bytes.size() / 2] ^= 0x10;
        line.arrive(bytes);
        return test::Hook::kDone;
    }
    test::Hook offer_ahead() override { return test::Hook::kCannot; }  // stamps are of the sensor's own clock
    test::Hook break_device() override {
        line.present = false;
        return test::Hook::kDone;
    }
    void repair_device() override { line.present = true; }
    test::Hook judges_silence() override { return test::Hook::kDone; }
    test::Hook end() override { return test::Hook::kCannot; }
    void pass_time() override { clock.advance(Duration::from_seconds(0.6)); }
    int held_back() const override { return 0; }

    SerialBytes next_packet() {
        sample.time_ns += kPeriodNs;
        ++sample.count;
        return test::packet_of(sensor_, sample);
    }

    static ImuSerialOptions options_of(SerialSensor sensor) {
        ImuSerialOptions options;
        options.sensor = sensor;
        options.silence = Duration::from_seconds(1.0);
        return options;
    }

private:
    SerialSensor sensor_;

public:
    ManualClock clock{{1'000'000'000}};
    test::FakeSerial line{clock};
    ImuSerial imu;
    test::SerialSample sample;
};

TEST_CASE("inertial sensors on serial lines keep the contract of their port", "[port_conformance]") {
    for (const SerialSensor sensor : kSensors) {
        CAPTURE(static_cast<int>(sensor));
        test::check_source_conformance<test::ImuHarness>([&] { return std::make_unique<SerialHarness>(sensor); });
    }
}

TEST_CASE("packets are found again behind garbage, in pieces of any size") {
    for (const SerialSensor sensor : kSensors) {
        for (const std::size_t largest : {std::size_t{1}, std::size_t{7}, std::size_t{4096}}) {
            CAPTURE(static_cast<int>(sensor), largest);
            SerialHarness h(sensor);
            h.line.largest = largest;
            REQUIRE(ok(h.imu.start()));
            CHECK(h.line.speed == 115200);
            std::mt19937 random(7);
            for (int i = 0; i < 50; ++i) {
                SerialBytes garbage(random() % 40);
                // Beginnings of packets among it, but of no long ones, which would hide those behind them.
                std::generate(garbage.begin(), garbage.end(), [&] { return static_cast<std::uint8_t>(random() % 4); });
                h.line.arrive(garbage);
                h.offer(1);
            }
            const SerialBytes half = h.next_packet();
            h.line.arrive(SerialBytes(half.begin(), half.begin() + static_cast<std::ptrdiff_t>(half.size() / 2)));
            h.offer(20);
            test::Drained all = test::drain(h);
            CHECK(all.stamps.size() >= 69);  // the cut one is lost, and one at most behind it
            Timestamp last;
            bool any = false;
            test::check_increasing(all.stamps, last, any);
        }
    }
}

TEST_CASE("samples have the values, axes and times that the sensor sent") {
    for (const SerialSensor sensor : kSensors) {
        CAPTURE(static_cast<int>(sensor));
        ImuSerialOptions options = SerialHarness::options_of(sensor);
        REQUIRE(ok(options.axes.parse("y -x z")));
        options.latency = Duration::from_seconds(0.002);
        ManualClock clock;
        test::FakeSerial line(clock);
        ImuSerial imu(line, clock, options);
        REQUIRE(ok(imu.start()));
        line.arrive(test::packet_of(sensor, {7'000'000'000}));
        ImuSample sample;
        REQUIRE(ok(imu.next({}, sample)));
        CHECK(sample.stamp.ns == 6'998'000'000);
        CHECK((sample.w_B - Eigen::Vector3d(-0.2, -0.1, 0.3)).norm() < 1e-6);
        CHECK((sample.a_B - Eigen::Vector3d(2.0, -1.0, -9.5)).norm() < 1e-5);
        CHECK(imu.clock() == ClockDomain::kDevice);
    }
}

TEST_CASE("a sensor whose clock begins again is followed, and lost packets are counted") {
    SerialHarness h(SerialSensor::kXsens);
    h.sample.time_ns = 3'600'000'000'000;
    REQUIRE(ok(h.imu.start()));
    h.offer(10);
    CHECK(test::drain(h).stamps.size() == 10);
    h.sample.count = static_cast<std::uint16_t>(h.sample.count + 3);
    h.offer(1);
    (void)test::drain(h);
    CHECK(h.imu.counters().lost == 3);
    h.sample.time_ns = 0;  // a brown-out
    h.offer(30);
    CHECK(test::drain(h).stamps.size() >= 20);
}

TEST_CASE("what is wrong with a stream is said") {
    const auto words_after = [](const SerialBytes& bytes) {
        SerialHarness h(SerialSensor::kVectorNav);
        REQUIRE(ok(h.imu.start()));
        for (int i = 0; i < 10; ++i) {
            h.line.arrive(bytes);
            (void)test::drain(h);
            h.pass_time();
        }
        CHECK(h.imu.counters().errors == 1);
        return std::string(h.imu.problem());
    };
    CHECK(words_after(SerialBytes(100, 0x55)).find("another protocol or baud rate") != std::string::npos);
    const SerialBytes attitude = test::from_hex("FA 01 0800 93502E42 833EF13F 48B504BB 9288");
    CHECK(words_after(attitude).find("TimeStartup and Imu of group 1") != std::string::npos);
}

TEST_CASE("over a pseudo-terminal of the kernel every packet arrives; a line that is hung up is reported") {
    const int far = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    REQUIRE(::grantpt(far) == 0);
    REQUIRE(::unlockpt(far) == 0);
    LinuxKernelIo io;
    LinuxClock clock;
    ImuSerialOptions options = SerialHarness::options_of(SerialSensor::kMicroStrain);
    options.device = ::ptsname(far);
    options.baud = 921600;
    ImuSerial imu(io, clock, options);
    if (const Status status = imu.start(); !ok(status)) {
        WARN("skipped: " << imu.problem());  // emulators of another processor may lack the call that sets any speed
        ::close(far);
        return;
    }
    test::SerialSample sent;
    for (int i = 0; i < 50; ++i) {
        sent.time_ns += kPeriodNs;
        const SerialBytes packet = test::microstrain_packet(sent);
        REQUIRE(::write(far, packet.data(), packet.size()) == static_cast<ssize_t>(packet.size()));
        ImuSample sample;
        REQUIRE(ok(imu.next(Duration::from_seconds(5.0), sample)));
        CHECK(sample.stamp.ns == sent.time_ns);
    }
    ::close(far);
    ImuSample sample;
    CHECK(imu.next(Duration::from_seconds(5.0), sample) == Status::kIo);
    CHECK_FALSE(imu.problem().empty());
}

}  // namespace
}  // namespace facet::imu_serial_test
