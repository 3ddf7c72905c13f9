// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_spi/icm42688.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/drivers/imu_spi/spi_harness.h"

namespace facet::icm42688_test {
namespace {

using Packet = std::array<std::uint8_t, IcmPacket::kSize>;

/// A packet with 20-bit values.
Packet make_packet(std::int32_t force_x, std::int32_t rate_x, std::uint16_t time, std::uint8_t header = 0x78) {
    Packet p{};
    p[0] = header;
    const auto put = [&](std::size_t at, std::int32_t value) {
        p[at] = static_cast<std::uint8_t>(value >> 12);
        p[at + 1] = static_cast<std::uint8_t>(value >> 4);
    };
    put(1, force_x);
    put(7, rate_x);
    put(5, 32768);   // force z: 1 g
    put(11, -4096);  // rate z
    p[13] = 0x05;    // 1325 / 132.48 + 25 = 35.0 deg C
    p[14] = 0x2D;
    p[15] = static_cast<std::uint8_t>(time >> 8);
    p[16] = static_cast<std::uint8_t>(time & 0xFF);
    p[17] = static_cast<std::uint8_t>(((force_x & 0xF) << 4) | (rate_x & 0xF));
    return p;
}

class FakeIcm final : public test::ByteRegisterChip {
public:
    FakeIcm() { reset(); }

    std::deque<Packet> fifo;
    double self_test_rate_dps = 100.0;
    double self_test_force_mg = 400.0;
    bool floating = false;  ///< nobody drives the data line

    bool is_on() const { return banks[0][0x4E] != 0; }
    /// Back to the defaults, as after a dip of the supply.
    void reset() {
        for (auto& bank : banks) {
            bank.fill(0);
        }
        banks[0][0x75] = 0x47;
        fifo.clear();
    }

private:
    void on_write(std::uint8_t address, std::uint8_t value) override {
        if (address == 0x76) {
            banks[0][0x76] = value;
            select_bank(value);
        } else if (address == 0x11 && (value & 1) != 0) {
            reset();
        } else if (address == 0x4B && (value & 2) != 0) {
            fifo.clear();
        } else if (address == 0x70) {
            const auto rate = static_cast<std::int16_t>(value != 0 ? self_test_rate_dps * 32768.0 / 2000.0 : 0.0);
            const auto force = static_cast<std::int16_t>(value != 0 ? self_test_force_mg * 32.768 / 16.0 : 0.0);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                put(0x1F + 2 * axis, force);
                put(0x25 + 2 * axis, rate);
            }
        }
    }
    void put(std::size_t at, std::int16_t value) {
        banks[0][at] = static_cast<std::uint8_t>(value >> 8);
        banks[0][at + 1] = static_cast<std::uint8_t>(value & 0xFF);
    }
    std::uint8_t on_read(std::uint8_t address, std::size_t index) override {
        if (floating) {
            return 0xFF;
        }
        if (address == 0x2E) {
            return static_cast<std::uint8_t>(index == 0 ? fifo.size() >> 8 : fifo.size() & 0xFF);
        }
        if (address == 0x30) {
            if (fifo.empty()) {
                return index % IcmPacket::kSize == 0 ? 0x80 : 0;
            }
            const std::uint8_t byte = fifo.front()[index % IcmPacket::kSize];
            if (index % IcmPacket::kSize == IcmPacket::kSize - 1) {
                fifo.pop_front();
            }
            return byte;
        }
        return test::ByteRegisterChip::on_read(address, index);
    }
};

class IcmHarness final : public test::SpiHarness {
public:
    explicit IcmHarness(const Icm42688Options& options = {}, Duration silence = {}) : chip(device, clock, options) {
        ImuSpiOptions source;
        source.silence = silence;
        imu = std::make_unique<ImuSpi>(chip, &edges, clock, source);
        edges.one_by_one = false;
        edges.period_ns = 1'000'000;
        edges.on_edge = [this](Timestamp) {
            time_us = static_cast<std::uint16_t>(time_us + 1000);
            device.fifo.push_back(make_packet(0, 0, time_us, corrupt_next ? 0x18 : 0x78));
            corrupt_next = false;
        };
    }
    void set_present(bool present) override { device.present = present; }
    /// As offer, but a chip that is off makes no interrupts.
    void run(int samples) {
        if (device.is_on()) {
            offer(samples);
        } else {
            clock.advance({samples * edges.period_ns});
        }
    }

    FakeIcm device;
    Icm42688 chip;
    std::uint16_t time_us = 60'000;
};

TEST_CASE("the ICM-42688-P keeps the contract of its port", "[port_conformance]") {
    test::check_source_conformance<test::ImuHarness>(
        [] { return std::make_unique<IcmHarness>(Icm42688Options{}, test::SpiHarness::kSilence); });
}

TEST_CASE("a device that has gone from its bus is a failure, not an empty FIFO") {
    IcmHarness h;
    REQUIRE(ok(h.imu->start()));
    h.offer(5);
    CHECK(test::drain(h).stamps.size() == 5);
    h.device.is_unbound = true;
    h.offer(1);
    ImuSample sample;
    CHECK(h.imu->next({}, sample) == Status::kIo);
    CHECK(h.imu->counters().errors == 1);
    h.device.is_unbound = false;
    h.pass_time();
    (void)test::drain(h);
    h.offer(5);
    CHECK(test::drain(h).stamps.size() == 5);
    CHECK(h.imu->counters().recoveries == 1);
}

TEST_CASE("a high-resolution packet, bit by bit") {
    Result<IcmPacket> packet = parse_icm_packet(make_packet(0x12345, -0x12345, 0xABCD));
    REQUIRE(packet.ok());
    CHECK(packet.value().force.x() == Approx(0x12345 * 16.0 * 9.80665 / 524288.0).epsilon(1e-14));
    CHECK(packet.value().rate.x() == Approx(-0x12345 * 2000.0 * kRadPerDeg / 524288.0).epsilon(1e-14));
    CHECK(packet.value().force.z() == Approx(9.80665).epsilon(1e-14));
    CHECK(packet.value().rate.z() == Approx(-15.625 * kRadPerDeg).epsilon(1e-14));
    CHECK(packet.value().temperature_c == Approx(35.0).margin(0.01));
    CHECK(packet.value().time == 0xABCD);
    CHECK(parse_icm_packet(make_packet(0, 0, 7, 0x80)).value().empty);
    // No extension, no time, an FSYNC delay instead of the time, an unplugged bus, the chip's mark for "invalid".
    for (const int header : {0x68, 0x70, 0x7C, 0x58, 0x00, 0xFF}) {
        CHECK(parse_icm_packet(make_packet(0, 0, 7, static_cast<std::uint8_t>(header))).status() == Status::kCorrupt);
    }
    CHECK(parse_icm_packet(make_packet(-524288, 0, 7)).status() == Status::kCorrupt);
}

TEST_CASE("packets of one watermark are placed by the chip's clock around the edge, across its wrap") {
    IcmHarness h({1000, 4, false});
    h.edges.period_ns = 4'000'000;
    h.edges.on_edge = [&](Timestamp) {
        for (int i = 0; i < 4; ++i) {
            h.time_us = static_cast<std::uint16_t>(h.time_us + 1000);
            h.device.fifo.push_back(make_packet(0, 0, h.time_us));
        }
    };
    REQUIRE(ok(h.imu->start()));
    h.offer(20);  // 80 ms from 60 ms on: wraps at 65.536 ms
    const test::Drained all = test::drain(h);
    REQUIRE(all.stamps.size() == 80);
    for (std::size_t i = 1; i < all.stamps.size(); ++i) {
        REQUIRE((all.stamps[i] - all.stamps[i - 1]).ns == 1'000'000);
    }
    CHECK(h.imu->counters().lost == 0);
    CHECK(all.stamps.back() == h.clock.now());
}

TEST_CASE("the ratio of the clocks is learnt") {
    IcmHarness h({1000, 10, false});
    // The chip is 2 % fast: its 1000 us last 980 us.
    h.edges.period_ns = 9'800'000;
    h.edges.on_edge = [&](Timestamp) {
        for (int i = 0; i < 10; ++i) {
            h.time_us = static_cast<std::uint16_t>(h.time_us + 1000);
            h.device.fifo.push_back(make_packet(0, 0, h.time_us));
        }
    };
    REQUIRE(ok(h.imu->start()));
    for (int i = 0; i < 400; ++i) {
        h.offer(1);
        (void)test::drain(h);
    }
    h.offer(1);
    const test::Drained last = test::drain(h);
    REQUIRE(last.stamps.size() == 10);
    CHECK(std::abs((last.stamps[9] - last.stamps[0]).ns - 8'820'000) < 2'000);
    CHECK(h.imu->counters().lost == 0);
}

TEST_CASE("edges that the kernel has merged carry the later one's stamp: no sample moves by a period") {
    for (const int watermark : {1, 2}) {
        CAPTURE(watermark);
        IcmHarness h({1000, static_cast<std::uint8_t>(watermark), false});
        int edge = 0;
        const auto add = [&] {
            for (int i = 0; i < watermark; ++i) {
                h.time_us = static_cast<std::uint16_t>(h.time_us + 1000);
                h.device.fifo.push_back(make_packet(0, 0, h.time_us));
            }
        };
        h.edges.period_ns = watermark * 1'000'000;
        h.edges.on_edge = [&](Timestamp) { add(); };
        REQUIRE(ok(h.imu->start()));
        test::Drained all;
        for (; edge < 200; ++edge) {
            if (edge % 7 == 6) {
                add();  // its edge was merged with the next one
                h.clock.advance({h.edges.period_ns});
            }
            h.offer(1);
            for (const Timestamp stamp : test::drain(h).stamps) {
                all.stamps.push_back(stamp);
            }
        }
        REQUIRE(all.stamps.size() > 200);
        for (std::size_t i = 1; i < all.stamps.size(); ++i) {
            CAPTURE(i);
            REQUIRE(std::abs((all.stamps[i] - all.stamps[i - 1]).ns - 1'000'000) < 1'000);
        }
    }
}

TEST_CASE("edges that are merged for a whole second move no sample either") {
    IcmHarness h({200, 1, false});
    const auto add = [&] {
        h.time_us = static_cast<std::uint16_t>(h.time_us + 5000);
        h.device.fifo.push_back(make_packet(0, 0, h.time_us));
    };
    h.edges.period_ns = 5'000'000;
    h.edges.on_edge = [&](Timestamp) { add(); };
    REQUIRE(ok(h.imu->start()));
    test::Drained all;
    for (int edge = 0; edge < 200; ++edge) {
        if (edge >= 50 && edge < 150) {
            add();
            h.clock.advance({h.edges.period_ns});
        }
        h.offer(1);
        for (const Timestamp stamp : test::drain(h).stamps) {
            all.stamps.push_back(stamp);
        }
    }
    REQUIRE(all.stamps.size() == 300);
    for (std::size_t i = 1; i < all.stamps.size(); ++i) {
        CAPTURE(i);
        REQUIRE(std::abs((all.stamps[i] - all.stamps[i - 1]).ns - 5'000'000) < 1'000);
    }
}

TEST_CASE("packets lost to a full FIFO show as a gap") {
    IcmHarness h;
    REQUIRE(ok(h.imu->start()));
    h.offer(5);
    (void)test::drain(h);
    h.time_us = static_cast<std::uint16_t>(h.time_us + 7000);
    h.offer(1);
    (void)test::drain(h);
    CHECK(h.imu->counters().lost == 7);
}

TEST_CASE("identity, self-test and bad settings are named") {
    std::string problem;
    IcmHarness wrong;
    wrong.device.floating = true;
    CHECK(wrong.chip.configure(SelfTest::kRun, problem) == Status::kNotFound);
    CHECK(problem == "ICM-42688-P: WHO_AM_I is 255, expected 71");
    IcmHarness gyro;
    gyro.device.self_test_rate_dps = 50.0;
    CHECK(gyro.chip.configure(SelfTest::kRun, problem) == Status::kIo);
    CHECK(problem == "ICM-42688-P: self-test of the gyroscope failed");
    IcmHarness accel;
    accel.device.self_test_force_mg = 1300.0;
    CHECK(accel.chip.configure(SelfTest::kRun, problem) == Status::kIo);
    CHECK(problem == "ICM-42688-P: self-test of the accelerometer failed");
    IcmHarness rate({123, 1, false});
    CHECK(rate.chip.configure(SelfTest::kRun, problem) == Status::kInvalidArgument);
}

TEST_CASE("a chip that comes back in flight is not tested again, one that is restarted is") {
    // GIVEN a chip that failed, and a vehicle whose motion would spoil a self-test
    IcmHarness h;
    REQUIRE(ok(h.imu->start()));
    h.break_device();
    (void)test::drain(h);
    h.device.self_test_rate_dps = 0.0;
    // WHEN the chip is there again
    h.repair_device();
    h.pass_time();
    (void)test::drain(h);
    h.offer(3);
    (void)test::drain(h);
    // THEN it gives samples, but does not pass a start
    CHECK(h.imu->counters().recoveries == 1);
    CHECK(h.imu->counters().delivered > 0);
    h.imu->stop();
    CHECK(h.imu->start() == Status::kIo);
}

TEST_CASE("a chip that a brown-out has reset makes no interrupts: it is set up again, in a tenth of a second") {
    IcmHarness h({}, Duration::from_seconds(0.1));
    REQUIRE(ok(h.imu->start()));
    h.run(50);
    CHECK(test::drain(h).stamps.size() > 40);
    h.device.reset();
    const Timestamp dip = h.clock.now();
    Timestamp back;
    for (int i = 0; i < 200 && back.ns == 0; ++i) {
        h.run(10);
        ImuSample sample;
        Status status = Status::kOk;
        while ((status = h.imu->next({}, sample)) == Status::kOk) {
            back = sample.stamp.ns > dip.ns ? sample.stamp : back;
        }
    }
    CHECK(back.ns > 0);
    CHECK((back - dip).seconds() < 0.5);
    CHECK(h.imu->problem().find("no data for 1") != std::string_view::npos);
    CHECK(h.imu->counters().errors == 1);
    CHECK(h.imu->counters().recoveries == 1);
}

TEST_CASE("a bus that comes loose gives corrupt readings, not samples") {
    IcmHarness h;
    REQUIRE(ok(h.imu->start()));
    h.device.floating = true;
    h.offer(1);
    ImuSample sample;
    CHECK(h.imu->next({}, sample) == Status::kCorrupt);
}

}  // namespace
}  // namespace facet::icm42688_test
