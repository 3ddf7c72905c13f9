// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_spi/adis16.h"

#include <catch2/catch.hpp>

#include "tests/drivers/imu_spi/fake_adis.h"
#include "tests/drivers/imu_spi/spi_harness.h"

namespace facet::adis16_test {
namespace {

using test::FakeAdis;

class AdisHarness final : public test::SpiHarness {
public:
    explicit AdisHarness(Adis16Model model, ClockDomain domain = ClockDomain::kMonotonic)
        : device(model), chip(device, clock, {model, 4, true}) {
        edges.domain = domain;
        imu = std::make_unique<ImuSpi>(chip, &edges, clock, judged_options());
        edges.on_edge = [this](Timestamp) {
            device.sample(100);
            device.flip_a_bit = corrupt_next;
            corrupt_next = false;
        };
    }
    void set_present(bool present) override { device.present = present; }

    FakeAdis device;
    Adis16 chip;
};

TEST_CASE("samples go on after the wall clock that stamps their data-ready edges was set back") {
    for (const Adis16Model model : {Adis16Model::k16448, Adis16Model::k16470}) {
        AdisHarness h(model, ClockDomain::kRealtime);
        h.edges.offset = Duration::from_seconds(7200.0);
        REQUIRE(ok(h.imu->start()));
        CHECK(h.imu->clock() == ClockDomain::kRealtime);
        const auto run = [&h](int samples) {
            int delivered = 0;
            for (int i = 0; i < samples; ++i) {
                h.offer(1);
                delivered += static_cast<int>(test::drain(h).stamps.size());
            }
            return delivered;
        };
        CHECK(run(20) == 20);
        h.edges.offset = Duration::from_seconds(3600.0);
        CHECK(run(20) == 20 - (IncreasingStamps::kSetBack - 1));
        CHECK(h.imu->counters().errors == 0);
    }
}

TEST_CASE("ADIS16448 and ADIS1647x keep the contract of their port", "[port_conformance]") {
    for (const Adis16Model model : {Adis16Model::k16448, Adis16Model::k16470, Adis16Model::k16475Dash2}) {
        INFO(adis16_variant(model).name);
        test::check_source_conformance<test::ImuHarness>([&] { return std::make_unique<AdisHarness>(model); });
    }
}

TEST_CASE("the two checksums") {
    // Sums by hand: 0x12 + 0x34 + 0xFF + 0xFF = 0x244.
    const std::array<std::uint16_t, 2> words{0x1234, 0xFFFF};
    CHECK(adis1647x_checksum(words) == 0x0244);
    // The CRC against a bit-by-bit division written the other way round: bytes, each from its least significant bit.
    const std::array<std::uint16_t, 3> more{0x0123, 0xFEDC, 0x8001};
    std::uint16_t crc = 0xFFFF;
    for (const std::uint8_t byte : {0x23, 0x01, 0xDC, 0xFE, 0x01, 0x80}) {
        for (int bit = 0; bit < 8; ++bit) {
            const int feedback = (crc & 1) ^ ((byte >> bit) & 1);
            crc = static_cast<std::uint16_t>(crc >> 1);
            if (feedback != 0) {
                crc ^= 0x1021;
            }
        }
    }
    crc = static_cast<std::uint16_t>(~crc);
    CHECK(adis16448_crc(more) == static_cast<std::uint16_t>((crc << 8) | (crc >> 8)));
}

TEST_CASE("scales of all members") {
    struct Expected {
        Adis16Model model;
        double deg_per_s;
        double g;
        double temperature;
    };
    // 4000 LSB; temperature word 100.
    const Expected table[] = {{Adis16Model::k16448, 160.0, 4000.0 / 1200.0, 38.386},
                              {Adis16Model::k16470, 400.0, 5.0, 10.0},
                              {Adis16Model::k16475Dash1, 25.0, 1.0, 10.0},
                              {Adis16Model::k16475Dash2, 100.0, 1.0, 10.0},
                              {Adis16Model::k16475Dash3, 400.0, 1.0, 10.0}};
    for (const Expected& expected : table) {
        INFO(adis16_variant(expected.model).name);
        AdisHarness h(expected.model);
        h.edges.on_edge = [&](Timestamp) {
            h.device.sample(0);
            h.device.data = {4000, 0, -4000, 0, -4000, 4000, 100};
        };
        REQUIRE(ok(h.imu->start()));
        h.offer(1);
        ImuSample sample;
        REQUIRE(h.imu->next({}, sample) == Status::kOk);
        CHECK((sample.w_B - Eigen::Vector3d(1, 0, -1) * expected.deg_per_s * kRadPerDeg).norm() < 1e-12);
        CHECK((sample.a_B - Eigen::Vector3d(0, -1, 1) * expected.g * 9.80665).norm() < 1e-12);
        CHECK(h.imu->temperature_c() == Approx(expected.temperature).epsilon(1e-12));
    }
}

TEST_CASE("the ADIS16448's temperature has 12 bits and a sign") {
    AdisHarness h(Adis16Model::k16448);
    h.edges.on_edge = [&](Timestamp) {
        h.device.sample(1);
        h.device.data[6] = -500;
    };
    REQUIRE(ok(h.imu->start()));
    h.offer(1);
    ImuSample sample;
    REQUIRE(h.imu->next({}, sample) == Status::kOk);
    CHECK(h.imu->temperature_c() == Approx(31.0 - 36.93));
}

TEST_CASE("the chip is set up as asked: rate, CRC, data-ready, SPI mode") {
    AdisHarness old(Adis16Model::k16448);
    REQUIRE(ok(old.imu->start()));
    CHECK(old.device.registers[0x34] == 0x0016);
    CHECK(old.device.registers[0x36] == 0x0401);
    CHECK(old.chip.rate_hz() == Approx(51.2));
    CHECK(old.device.settings.mode == 3);
    CHECK(old.device.settings.speed_hz <= 1'000'000);
    AdisHarness h(Adis16Model::k16470);
    REQUIRE(ok(h.imu->start()));
    CHECK(h.device.registers[0x64] == 4);
    CHECK(h.device.registers[0x60] == 0x00C1);
    CHECK(h.chip.rate_hz() == 400.0);
}

TEST_CASE("another chip, another range, a failed self-test are named") {
    AdisHarness other(Adis16Model::k16470);
    FakeAdis wrong(Adis16Model::k16475Dash2);
    Adis16 chip(wrong, other.clock, {Adis16Model::k16470, 0, true});
    std::string problem;
    CHECK(chip.configure(SelfTest::kRun, problem) == Status::kNotFound);
    CHECK(problem == "ADIS16470: product id is 16475, expected 16470");
    Adis16 range(wrong, other.clock, {Adis16Model::k16475Dash3, 0, true});
    CHECK(range.configure(SelfTest::kRun, problem) == Status::kNotFound);
    CHECK(problem == "ADIS16475-3: the chip has a different range (RANG_MDL 4)");
    for (const Adis16Model model : {Adis16Model::k16448, Adis16Model::k16470}) {
        AdisHarness h(model);
        h.device.failing_self_test = true;
        CHECK(h.imu->start() == Status::kIo);
        CHECK(h.imu->problem().find("self-test failed (DIAG_STAT 2080)") != std::string_view::npos);
    }
    AdisHarness dead(Adis16Model::k16470);
    dead.device.dead = true;
    CHECK(dead.imu->start() == Status::kNotFound);
}

TEST_CASE("lost samples are counted by the counter, or by the edges where there is none") {
    for (const Adis16Model model : {Adis16Model::k16448, Adis16Model::k16470}) {
        AdisHarness h(model);
        REQUIRE(ok(h.imu->start()));
        h.offer(3);
        (void)test::drain(h);
        h.edges.lose(4);
        h.device.counter = static_cast<std::uint16_t>(h.device.counter + 4);
        h.offer(3);
        (void)test::drain(h);
        CHECK(h.imu->counters().lost == 4);
        CHECK(h.imu->counters().delivered == 6);
    }
    AdisHarness h(Adis16Model::k16470);
    REQUIRE(ok(h.imu->start()));
    h.device.counter = 0xFFFE;
    h.offer(4);
    (void)test::drain(h);
    CHECK(h.imu->counters().lost == 0);  // over the wrap
}

TEST_CASE("a sample read too late gets the stamp of its own edge, and is not given twice") {
    AdisHarness h(Adis16Model::k16470);
    h.edges.period_ns = 2'500'000;
    bool late = false;
    h.edges.on_edge = [&](Timestamp) {
        if (!late) {
            h.device.sample(1);
        }
    };
    REQUIRE(ok(h.imu->start()));
    h.offer(1);
    ImuSample first;
    REQUIRE(h.imu->next({}, first) == Status::kOk);
    // Between this edge and the reading the next sample came.
    h.device.sample(1);
    h.offer(1);
    ImuSample sample;
    REQUIRE(h.imu->next({}, sample) == Status::kOk);
    CHECK((sample.stamp - first.stamp).ns == 5'000'000);
    late = true;  // the edge of that sample brings nothing new
    h.offer(1);
    CHECK(h.imu->next({}, sample) == Status::kNotReady);
    late = false;
    h.offer(1);
    REQUIRE(h.imu->next({}, sample) == Status::kOk);
    CHECK((sample.stamp - first.stamp).ns == 7'500'000);
}

TEST_CASE("edges that the kernel has merged carry the later one's stamp: the sample keeps it") {
    AdisHarness h(Adis16Model::k16470);
    h.edges.period_ns = 2'500'000;
    h.edges.on_edge = [&](Timestamp) { h.device.sample(1); };
    REQUIRE(ok(h.imu->start()));
    h.offer(1);
    ImuSample first;
    REQUIRE(h.imu->next({}, first) == Status::kOk);
    h.device.sample(1);
    h.clock.advance({2'500'000});
    h.offer(1);
    ImuSample sample;
    REQUIRE(h.imu->next({}, sample) == Status::kOk);
    CHECK((sample.stamp - first.stamp).ns == 5'000'000);
    h.offer(1);
    REQUIRE(h.imu->next({}, sample) == Status::kOk);
    CHECK((sample.stamp - first.stamp).ns == 7'500'000);
}

TEST_CASE("failure flags and a dead bus drop samples, and many in a row reset the chip") {
    AdisHarness h(Adis16Model::k16470);
    REQUIRE(ok(h.imu->start()));
    h.device.status = 1U << 7;  // clock error
    h.offer(1);
    ImuSample sample;
    CHECK(h.imu->next({}, sample) == Status::kCorrupt);
    h.device.status = 1U << 4;  // standby: no reason
    h.offer(1);
    CHECK(h.imu->next({}, sample) == Status::kOk);
    h.device.dead = true;
    Status status = Status::kOk;
    int reads = 0;
    while (status != Status::kIo && reads < 100) {
        h.offer(1);
        status = h.imu->next({}, sample);
        ++reads;
    }
    CHECK(reads == 20);
    CHECK(h.imu->problem() == "imu_spi: 20 bad readings in a row");
    h.device.dead = false;
    h.pass_time();
    CHECK(h.imu->next({}, sample) == Status::kNotReady);  // resets the chip, and forgets edges of the time before
    h.offer(1);
    CHECK(h.imu->next({}, sample) == Status::kOk);
    CHECK(h.imu->counters().recoveries == 1);
}

TEST_CASE("without a data-ready line the chip is polled at the period") {
    ManualClock clock({1'000'000'000});
    FakeAdis device(Adis16Model::k16448);
    Adis16 chip(device, clock, {Adis16Model::k16448, 2, false});
    ImuSpi imu(chip, nullptr, clock, {});
    REQUIRE(ok(imu.start()));
    device.sample(5);
    ImuSample a;
    ImuSample b;
    REQUIRE(imu.next({}, a) == Status::kOk);
    CHECK(imu.next({}, b) == Status::kNotReady);
    CHECK(imu.next({2'000'000}, b) == Status::kNotReady);
    REQUIRE(imu.next({10'000'000}, b) == Status::kOk);
    CHECK((b.stamp - a.stamp).ns == 5'000'000);
}

}  // namespace
}  // namespace facet::adis16_test
