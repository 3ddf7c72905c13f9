// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_spi/bmi088.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/drivers/imu_spi/spi_harness.h"

namespace facet::bmi088_test {
namespace {

/// The accelerometer's die: needs a first read to come up in SPI mode, has a dummy byte, keeps its own time.
class FakeAccel final : public test::ByteRegisterChip {
public:
    explicit FakeAccel(ManualClock& clock) : test::ByteRegisterChip(1), clock_(clock) {
        registers()[0x00] = 0x1E;
        registers()[0x22] = 0x00;
        registers()[0x23] = 0x40;  // 23.25 deg C
    }
    double tick_ns = 39062.5;
    double self_test_g = 1.2;
    bool floating = false;
    /// True force along x at an instant (g).
    std::function<double(Timestamp)> force_g = [](Timestamp) { return 0.0; };
    std::int64_t phase_ns = 123'456;

private:
    std::uint8_t on_read(std::uint8_t address, std::size_t index) override {
        if (floating) {
            return 0xFF;
        }
        if (address == 0x12 && index == 0) {
            latch();
        }
        return test::ByteRegisterChip::on_read(address, index);
    }
    void latch() {
        const auto ticks = static_cast<std::int64_t>(static_cast<double>((clock_.now().ns + phase_ns)) / tick_ns);
        const std::int64_t sample_ticks = ticks / 16 * 16;
        const Timestamp sampled{static_cast<std::int64_t>(static_cast<double>(sample_ticks) * tick_ns) - phase_ns};
        double g = force_g(sampled);
        const std::uint8_t test = registers()[0x6D];
        g += test == 0x0D ? self_test_g / 2 : (test == 0x09 ? -self_test_g / 2 : 0.0);
        const double range_g = 3.0 * (1 << (registers()[0x41] & 3));
        const auto raw = static_cast<std::int16_t>(std::lround(g / range_g * 32768.0));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int16_t value = axis == 0 || test != 0 ? raw : 0;
            registers()[0x12 + 2 * axis] = static_cast<std::uint8_t>(value & 0xFF);
            registers()[0x13 + 2 * axis] = static_cast<std::uint8_t>(value >> 8);
        }
        for (std::size_t i = 0; i < 3; ++i) {
            registers()[0x18 + i] = static_cast<std::uint8_t>(ticks >> (8 * i));
        }
    }
    ManualClock& clock_;
};

class FakeGyro final : public test::ByteRegisterChip {
public:
    FakeGyro() { registers()[0x00] = 0x0F; }
    bool failing_self_test = false;
    bool is_dead = false;  ///< its line says nothing but ones, or zeros
    std::uint8_t dead_byte = 0;

private:
    std::uint8_t on_read(std::uint8_t address, std::size_t index) override {
        return is_dead ? dead_byte : test::ByteRegisterChip::on_read(address, index);
    }
    void on_write(std::uint8_t address, std::uint8_t) override {
        if (address == 0x3C) {
            registers()[0x3C] = failing_self_test ? 0x06 : 0x12;
        }
    }
};

class BmiHarness final : public test::SpiHarness {
public:
    explicit BmiHarness(const Bmi088Options& options = {}) : chip(gyro, accel, clock, options) {
        imu = std::make_unique<ImuSpi>(chip, &edges, clock, judged_options());
        edges.period_ns = 2'500'000;
        edges.on_edge = [this](Timestamp) {
            accel.floating = corrupt_next;
            corrupt_next = false;
        };
    }
    void set_present(bool present) override {
        gyro.present = present;
        accel.present = present;
    }
    void pass_time() override {
        accel.floating = false;
        SpiHarness::pass_time();
    }
    int held_back() const override { return 2; }  // the first rate has no force before it, the last none after

    FakeAccel accel{clock};
    FakeGyro gyro;
    Bmi088 chip;
};

TEST_CASE("the BMI088 keeps the contract of its port", "[port_conformance]") {
    test::check_source_conformance<test::ImuHarness>([] { return std::make_unique<BmiHarness>(); });
}

TEST_CASE("forces of the other die are interpolated to the gyroscope's stamps") {
    BmiHarness h;
    // 1 g/s along x; the gyroscope's rate is constant 1000 deg/s about y.
    h.accel.force_g = [](Timestamp t) { return (t.seconds() - 1.5) * 1.0; };
    REQUIRE(ok(h.imu->start()));
    h.gyro.registers()[0x04] = 0x00;
    h.gyro.registers()[0x05] = 0x40;  // 16384
    h.offer(200);
    int given = 0;
    double worst_g = 0.0;
    for (int i = 0; i < 1000; ++i) {
        ImuSample sample;
        if (!ok(h.imu->next({}, sample))) {
            continue;
        }
        ++given;
        worst_g = std::max(worst_g, std::abs(sample.a_B.x() / 9.80665 - (sample.stamp.seconds() - 1.5)));
        CHECK(sample.w_B.y() == Approx(16384.0 / 32767.0 * 2000.0 * kRadPerDeg).epsilon(1e-12));
    }
    CHECK(given >= 198);
    // One tick of 39 us at 1 g/s is 4e-5 g; the least significant bit at 12 g is 3.7e-4 g.
    CHECK(worst_g < 4.5e-4);
    CHECK(h.imu->counters().discarded <= 1);
    CHECK(h.imu->temperature_c() == 23.25);
}

TEST_CASE("both dies are set up and identified") {
    BmiHarness h({1000, 3, true});
    REQUIRE(ok(h.imu->start()));
    CHECK(h.accel.registers()[0x40] == 0xAC);
    CHECK(h.accel.registers()[0x41] == 3);
    CHECK(h.accel.registers()[0x7D] == 4);
    CHECK(h.accel.registers()[0x6D] == 0);
    CHECK(h.gyro.registers()[0x10] == 0x82);
    CHECK(h.gyro.registers()[0x15] == 0x80);
    std::string problem;
    BmiHarness wrong;
    wrong.accel.registers()[0x00] = 0x1F;
    CHECK(wrong.chip.configure(SelfTest::kRun, problem) == Status::kNotFound);
    CHECK(problem == "BMI088 accelerometer: chip id is 31, expected 30");
    BmiHarness wrong_gyro;
    wrong_gyro.gyro.registers()[0x00] = 0;
    CHECK(wrong_gyro.chip.configure(SelfTest::kRun, problem) == Status::kNotFound);
    CHECK(problem == "BMI088 gyroscope: chip id is 0, expected 15");
    BmiHarness weak;
    weak.accel.self_test_g = 0.9;
    CHECK(weak.chip.configure(SelfTest::kRun, problem) == Status::kIo);
    CHECK(problem == "BMI088 accelerometer: self-test failed");
    BmiHarness broken;
    broken.gyro.failing_self_test = true;
    CHECK(broken.chip.configure(SelfTest::kRun, problem) == Status::kIo);
    CHECK(problem == "BMI088 gyroscope: self-test failed");
    BmiHarness settings({333, 2, true});
    CHECK(settings.chip.configure(SelfTest::kRun, problem) == Status::kInvalidArgument);
}

TEST_CASE("a gyroscope whose line is dead gives no rates of zero, and is set up again") {
    for (const int byte : {0x00, 0xFF}) {
        CAPTURE(byte);
        BmiHarness h;
        REQUIRE(ok(h.imu->start()));
        h.offer(10);
        CHECK(test::drain(h).stamps.size() >= 8);
        h.gyro.dead_byte = static_cast<std::uint8_t>(byte);
        h.gyro.is_dead = true;
        h.offer(30);
        const test::Drained dead = test::drain(h);
        CHECK(dead.stamps.size() <= 1);  // the one that waited for a force
        CHECK(h.imu->counters().corrupt >= 20);
        CHECK(h.imu->counters().errors == 1);
        h.gyro.is_dead = false;
        h.pass_time();
        h.offer(10);
        CHECK(test::drain(h).stamps.size() >= 6);
        CHECK(h.imu->counters().recoveries == 1);
    }
}

TEST_CASE("edges stamped by the wall clock are joined with forces stamped by the same, also when it is set") {
    Bmi088Options options;
    options.clock = ClockDomain::kRealtime;
    BmiHarness h(options);
    h.edges.domain = ClockDomain::kRealtime;
    h.imu = std::make_unique<ImuSpi>(h.chip, &h.edges, h.clock, BmiHarness::judged_options());
    const auto set = [&](Duration offset) {
        h.edges.offset = offset;
        h.clock.set_realtime_offset(offset);
    };
    set(Duration::from_seconds(1.7e9));
    REQUIRE(ok(h.imu->start()));
    h.offer(100);
    CHECK(test::drain(h).stamps.size() >= 98);
    set(Duration::from_seconds(1.7e9 - 3600.0));
    h.offer(100);
    const test::Drained after = test::drain(h);
    CHECK(after.stamps.size() >= 85);
    CHECK(after.stamps.back().seconds() < 1.7e9 - 3000.0);
    CHECK(h.imu->counters().errors == 0);
}

TEST_CASE("lost edges are counted") {
    BmiHarness h;
    REQUIRE(ok(h.imu->start()));
    h.offer(3);
    (void)test::drain(h);
    h.edges.lose(5);
    h.offer(3);
    (void)test::drain(h);
    CHECK(h.imu->counters().lost == 5);
}

}  // namespace
}  // namespace facet::bmi088_test
