// SPDX-License-Identifier: BSD-2-Clause
// Packets from the sensors' documents, or recorded, and what is read from them.
#include <catch2/catch.hpp>

#include "drivers/imu_serial/microstrain.h"
#include "drivers/imu_serial/vectornav.h"
#include "drivers/imu_serial/xsens.h"
#include "tests/drivers/imu_serial/serial_packets.h"

namespace facet::serial_protocols_test {
namespace {

using test::from_hex;
using test::SerialBytes;
using Kind = SerialFrame::Kind;

SerialReading read(SerialProtocol& protocol, const SerialBytes& packet) {
    const SerialFrame frame = protocol.frame(packet);
    CHECK(frame.kind == Kind::kWhole);
    CHECK(frame.size == packet.size());
    for (std::size_t size = 1; size < packet.size(); ++size) {
        CHECK(protocol.frame(std::span(packet).first(size)).kind == Kind::kUnfinished);
    }
    for (std::size_t i = 0; i < packet.size(); ++i) {
        SerialBytes damaged = packet;
        damaged[i] ^= 0x04;
        CHECK(protocol.frame(damaged).kind != Kind::kWhole);
    }
    SerialReading reading;
    protocol.read(packet, reading);
    return reading;
}

TEST_CASE("VectorNav's example packet is whole, and packets of one's own choice are read") {
    VectorNav protocol;
    // Yaw, pitch and roll: the first example of UM001, section 4.3.
    const SerialReading none = read(protocol, from_hex("FA 01 0800 93502E42 833EF13F 48B504BB 9288"));
    CHECK(!none.rate);
    CHECK(!none.force);
    CHECK(!none.time_ns);
    const test::SerialSample sample{123'456'789'012};
    const SerialReading imu = read(protocol, test::vectornav_packet(sample));
    CHECK(imu.time_ns == sample.time_ns);
    CHECK((*imu.rate - sample.rate).norm() < 1e-7);
    CHECK((*imu.force - sample.force).norm() < 1e-6);
}

TEST_CASE("VectorNav's fields are found behind those of all groups") {
    VectorNav protocol;
    // TimeStartup and Ypr of group 1; UncompAccel, UncompGyro and Temp of group 3; a rotation matrix of group 5.
    SerialBytes body{0x15, 0x09, 0x00, 0x1C, 0x00, 0x08, 0x00};
    test::append(body, std::uint64_t{5'000'000'000}, std::endian::little);
    test::append(body, Eigen::Vector3d(1, 2, 3), std::endian::little);
    test::append(body, Eigen::Vector3d(4, 5, 6), std::endian::little);
    test::append(body, Eigen::Vector3d(7, 8, 9), std::endian::little);
    test::append(body, 36.5F, std::endian::little);
    body.resize(body.size() + 36);
    // Any two last bytes leave a rest of 16 bits; the right ones leave none.
    SerialBytes packet;
    for (int crc = 0; crc < 0x10000 && packet.empty(); ++crc) {
        SerialBytes tried{0xFA};
        tried.insert(tried.end(), body.begin(), body.end());
        test::append(tried, static_cast<std::uint16_t>(crc), std::endian::big);
        packet = protocol.frame(tried).kind == Kind::kWhole ? tried : SerialBytes{};
    }
    REQUIRE(!packet.empty());
    const SerialReading reading = read(protocol, packet);
    CHECK(reading.time_ns == 5'000'000'000);
    CHECK(*reading.force == Eigen::Vector3d(4, 5, 6));
    CHECK(*reading.rate == Eigen::Vector3d(7, 8, 9));
    CHECK(reading.temperature_c == 36.5);
}

TEST_CASE("an MTi-300's recorded packet is read as its maker's program reads it") {
    Xsens protocol;
    const SerialBytes data = from_hex(
        "10 20 02 91 8D 10 60 04 01 36 3F A6 20 10 10 3F 35 E0 42 3F 31 CD 15 BD 9F 49 DB BD A9 38 CF 40 20 0C BD 63 "
        "5A "
        "90 41 1D 08 D4 3E 5F AA 50 40 10 0C B9 11 68 00 3C C9 01 00 3A 0F 7D 00 40 30 0C BC 3B 29 80 3C 35 FC 00 3C "
        "A4 "
        "6E 00 80 20 0C 3C AE A2 41 BB 56 D8 00 BA D5 AC 01 80 30 10 3F 80 00 00 37 DF 88 01 B6 89 80 00 B6 08 C0 00 "
        "C0 "
        "20 0C BE FB FB F2 3F 33 C4 85 BF A0 A2 C1 08 10 04 42 16 80 00 30 10 04 00 01 86 E1 E0 20 04 00 40 00 03");
    const SerialReading reading = read(protocol, test::xsens_message(0x36, data));
    CHECK(reading.time_ns == 20'332'454 * std::int64_t{100'000});
    CHECK((*reading.force - Eigen::Vector3d(-0.05550629, 9.81465530, 0.21842313)).norm() < 1e-7);
    CHECK((*reading.rate - Eigen::Vector3d(0.02131760, -0.00327826, -0.00163019)).norm() < 1e-7);
    CHECK(reading.temperature_c == 37.625);
    // Messages with checksums from the maker's documents: GoToConfig, and the device's answer with its identity.
    CHECK(protocol.frame(from_hex("FA FF 30 00 D1")).kind == Kind::kWhole);
    CHECK(protocol.frame(from_hex("FA FF 03 04 03 70 03 F8 8C")).kind == Kind::kWhole);
    SerialReading none;
    protocol.read(from_hex("FA FF 30 00 D1"), none);
    CHECK(!none.rate);
}

TEST_CASE("Xsens: counted packets, times over the end of 32 bits, other numbers, long messages") {
    Xsens protocol;
    const auto at = [&](std::int64_t tick, std::uint16_t count) {
        SerialReading reading;
        test::SerialSample sample{tick * 100'000};
        sample.count = count;
        protocol.read(test::xsens_packet(sample), reading);
        return reading;
    };
    CHECK(at(0xFFFF'FFF0, 0xFFFE).lost == 0);
    const SerialReading over = at(0x1'0000'0010, 0x0001);
    CHECK(over.lost == 2);
    CHECK(over.time_ns == std::int64_t{0x1'0000'0010} * 100'000);
    CHECK(*at(5, 2).time_ns < *over.time_ns);  // the sensor was reset

    SerialBytes data = from_hex("1060 04 00000001 4023 18");
    for (const double value : {1.5, -2.5, 9.75}) {
        test::append(data, value, std::endian::big);
    }
    const SerialBytes fixed = from_hex("8021 0C 00180000 FFF00000 00000001");  // 12.20
    data.insert(data.end(), fixed.begin(), fixed.end());
    data.insert(data.end(), {0x40, 0x12, 0xF8});  // an item that is passed over, so that the length takes two bytes
    data.resize(data.size() + 0xF8);
    SerialReading reading;
    const SerialBytes message = test::xsens_message(0x36, data);
    CHECK(message[3] == 0xFF);
    REQUIRE(protocol.frame(message).kind == Kind::kWhole);
    protocol.read(message, reading);
    CHECK(*reading.force == Eigen::Vector3d(1.5, -2.5, 9.75));
    CHECK(*reading.rate == Eigen::Vector3d(1.5, -1.0, 1.0 / (1 << 20)));
}

TEST_CASE("MicroStrain's example packet is read, and its times") {
    MicroStrain protocol;
    // "Data overview" of the 3DM-CV7's manual.
    const SerialReading example = read(protocol, from_hex("7565 800E 0E04 3E7A63A0 BB8E3B29 7FE5BF7F 84EE"));
    CHECK(example.force->x() == Approx(0.24452 * 9.80665).epsilon(1e-4));
    CHECK(!example.rate);
    const test::SerialSample sample{1'234'567'890'123};
    const SerialReading whole = read(protocol, test::microstrain_packet(sample));
    CHECK(whole.time_ns == sample.time_ns);
    CHECK((*whole.rate - sample.rate).norm() < 1e-7);
    CHECK((*whole.force - sample.force).norm() < 1e-6);

    SerialBytes fields{0x0E, 0x12};
    test::append(fields, 345'678.25, std::endian::big);
    fields.insert(fields.end(), {0x08, 0x00, 0x00, 0x07});
    SerialReading week;
    protocol.read(test::mip_packet(0x80, fields), week);
    CHECK(week.time_ns == 345'678'250'000'000);
    SerialReading other;
    protocol.read(test::mip_packet(0x82, fields), other);  // of the filter's set
    CHECK(!other.time_ns);
}

}  // namespace
}  // namespace facet::serial_protocols_test
