// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_can/dronecan.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/drivers/imu_can/fake_can_bus.h"

namespace facet::dronecan_test {
namespace {

constexpr std::uint32_t kId = (16U << 24) | (1003U << 8) | 42U;

/// One transfer, number 5, made with Python's struct ('e' for binary16) and binascii.crc_hqx over signature and
/// payload: rate (0.5, -0.25, 0.125), force (0, -1.5, 9.8125), no integrals.
std::vector<CanFrame> golden(int transfer = 5, std::uint32_t id = kId) {
    std::vector<CanFrame> frames{
        test::make_frame(id, true, {0x78, 0x78, 0x15, 0xCD, 0x5B, 0x07, 0x00, 0x80}, 1000),
        test::make_frame(id, true, {0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x20}, 1100),
        test::make_frame(id, true, {0x38, 0x00, 0xB4, 0x00, 0x30, 0x00, 0x00, 0x00}, 1200),
        test::make_frame(id, true, {0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x20}, 1300),
        test::make_frame(id, true, {0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xBE, 0x00}, 1400),
        test::make_frame(id, true, {0xE8, 0x48, 0x00, 0x00, 0x00, 0x00, 0x00, 0x20}, 1500),
        test::make_frame(id, true, {0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x40}, 1600),
    };
    for (CanFrame& frame : frames) {
        frame.bytes[7] = static_cast<std::uint8_t>(frame.bytes[7] | transfer);
    }
    return frames;
}

/// The statuses of all but the last frame must be kNotReady; gives that of the last.
Status feed(DroneCanDecoder& decoder, const std::vector<CanFrame>& frames, CanMeasurement& m) {
    for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
        CHECK(decoder.decode(frames[i], m) == Status::kNotReady);
    }
    return decoder.decode(frames.back(), m);
}

TEST_CASE("CRC-16/CCITT-FALSE gives the catalogue's check value") {
    const std::array<std::uint8_t, 9> text{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    CHECK(crc16_ccitt_false(text) == 0x29B1);
}

TEST_CASE("binary16 numbers") {
    CHECK(float16_to_double(0x3C00) == 1.0);
    CHECK(float16_to_double(0xC000) == -2.0);
    CHECK(float16_to_double(0x7BFF) == 65504.0);
    CHECK(float16_to_double(0x03FF) == 6.097555160522461e-05);
    CHECK(float16_to_double(0x0001) == 5.960464477539063e-08);
    CHECK(float16_to_double(0x3555) == 0.333251953125);
    CHECK(std::signbit(float16_to_double(0x8000)));
    CHECK(std::isinf(float16_to_double(0xFC00)));
    CHECK(std::isnan(float16_to_double(0x7E00)));
}

TEST_CASE("a golden transfer of seven frames") {
    DroneCanDecoder decoder;
    CanMeasurement m;
    REQUIRE(feed(decoder, golden(), m) == Status::kOk);
    CHECK(*m.rate == Eigen::Vector3d(0.5, -0.25, 0.125));
    CHECK(*m.force == Eigen::Vector3d(0.0, -1.5, 9.8125));
    CHECK(m.age.ns == 600);  // back to the stamp of the first frame
    CHECK(m.lost == 0);
    REQUIRE(feed(decoder, golden(9), m) == Status::kOk);
    CHECK(m.lost == 3);
    REQUIRE(feed(decoder, golden(8), m) == Status::kOk);
    CHECK(m.lost == 30);
}

TEST_CASE("a CAN FD frame holds the whole message; integrals are means over their interval") {
    CanFrame frame = test::make_frame(
        kId, true, {0x15, 0xCD, 0x5B, 0x07, 0x00, 0x00, 0x00, 0x6F, 0x12, 0x83, 0x3A, 0x00, 0x38, 0x00, 0xB4, 0x00,
                    0x30, 0x17, 0xB7, 0x51, 0x3A, 0x17, 0xB7, 0xD1, 0xB9, 0x17, 0xB7, 0x51, 0x39, 0x00, 0x00, 0x00,
                    0xBE, 0xE8, 0x48, 0x6F, 0x12, 0x83, 0x3A, 0x6F, 0x12, 0x03, 0xBB, 0x1F, 0xBA, 0x20, 0x3C, 0xC7});
    frame.fd = true;
    CanMeasurement m;
    DroneCanDecoder decoder;
    REQUIRE(decoder.decode(frame, m) == Status::kOk);
    CHECK((*m.rate - Eigen::Vector3d(0.8, -0.4, 0.2)).norm() < 1e-6);
    CHECK((*m.force - Eigen::Vector3d(1.0, -2.0, 9.81)).norm() < 2e-6);
    CHECK(std::abs(m.age.ns - 500'000) < 2);
    DroneCanDecoder latest({-1, false});
    REQUIRE(latest.decode(frame, m) == Status::kOk);
    CHECK(*m.rate == Eigen::Vector3d(0.5, -0.25, 0.125));
    CHECK(m.age.ns == 0);
}

TEST_CASE("every single changed bit of the payload is found by the CRC") {
    const std::vector<CanFrame> good = golden();
    for (std::size_t f = 0; f < good.size(); ++f) {
        for (int bit = 0; bit < 56; ++bit) {
            std::vector<CanFrame> bad = good;
            bad[f].bytes[static_cast<std::size_t>(bit / 8)] ^= static_cast<std::uint8_t>(1 << (bit % 8));
            DroneCanDecoder decoder;
            CanMeasurement m;
            REQUIRE(feed(decoder, bad, m) == Status::kCorrupt);
        }
    }
}

TEST_CASE("lost, repeated and foreign frames") {
    CanMeasurement m;
    for (std::size_t lost = 1; lost < 7; ++lost) {
        DroneCanDecoder decoder;
        std::vector<CanFrame> frames = golden();
        frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(lost));
        bool corrupt = false;
        for (const CanFrame& frame : frames) {
            const Status status = decoder.decode(frame, m);
            CHECK(status != Status::kOk);
            corrupt = corrupt || status == Status::kCorrupt;
        }
        // If the end was lost, the next transfer's start finds it. The next transfer is whole either way.
        const std::vector<CanFrame> next = golden(6);
        Status last = Status::kOk;
        for (const CanFrame& frame : next) {
            last = decoder.decode(frame, m);
            corrupt = corrupt || last == Status::kCorrupt;
        }
        CHECK(last == Status::kOk);
        CHECK(corrupt);
    }
    DroneCanDecoder decoder;
    std::vector<CanFrame> repeated = golden();
    repeated.insert(repeated.begin() + 3, repeated[2]);
    CHECK(feed(decoder, repeated, m) == Status::kOk);
    // Only the first node heard counts, and services and other types do not.
    CHECK(decoder.decode(golden(7, kId + 1)[0], m) == Status::kNotFound);
    CHECK(decoder.decode(golden(7, kId | 0x80U)[0], m) == Status::kNotFound);
    CHECK(decoder.decode(golden(7, kId + 256)[0], m) == Status::kNotFound);
    CHECK(decoder.decode(test::make_frame(kId, true, {}), m) == Status::kCorrupt);
    CHECK(decoder.filters()[0].value == 1003U << 8);
    CHECK(decoder.filters()[0].mask == 0x00FFFF80U);
    CHECK(DroneCanDecoder({42, true}).filters()[0].mask == 0x00FFFFFFU);
}

TEST_CASE("a transfer that never ends does not overrun the buffer") {
    DroneCanDecoder decoder;
    CanMeasurement m;
    CanFrame frame = golden()[0];
    CHECK(decoder.decode(frame, m) == Status::kNotReady);
    bool refused = false;
    for (int i = 1; i < 100 && !refused; ++i) {
        frame.bytes[7] = static_cast<std::uint8_t>(5 | (i % 2 != 0 ? 0x20 : 0));
        refused = decoder.decode(frame, m) == Status::kCorrupt;
        CHECK(i < 20);
    }
    CHECK(refused);
}

}  // namespace
}  // namespace facet::dronecan_test
