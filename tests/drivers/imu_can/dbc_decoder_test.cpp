// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_can/dbc_decoder.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "drivers/imu_can/openimu300.h"
#include "tests/drivers/imu_can/fake_can_bus.h"

namespace facet::dbc_decoder_test {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;

DbcDecoder openimu(CanSignalMap map = openimu300_map()) {
    DbcFile file;
    std::string error;
    REQUIRE(file.parse(openimu300_dbc(), "openimu300", error) == Status::kOk);
    DbcDecoder decoder;
    REQUIRE(decoder.configure(file, map, error) == Status::kOk);
    return decoder;
}

TEST_CASE("golden frames of the OpenIMU300") {
    DbcDecoder decoder = openimu();
    CanMeasurement m;
    // 1 deg/s = (1 + 250) * 128 = 0x7D80; -2 deg/s = 0x7C00; 0 = 0x7D00.
    REQUIRE(decoder.decode(test::make_frame(0x0CF02A80, true, {0x80, 0x7D, 0x00, 0x7C, 0x00, 0x7D, 0xFF, 0xFF}), m) ==
            Status::kOk);
    REQUIRE(m.rate);
    CHECK_FALSE(m.force);
    CHECK((*m.rate - Eigen::Vector3d(kDeg, -2.0 * kDeg, 0.0)).norm() < 1e-15);
    // 9.81 m/s^2 = 32981 = 0x80D5; -1 = 31900 = 0x7C9C; 0 = 32000 = 0x7D00. Another priority and source address.
    REQUIRE(decoder.decode(test::make_frame(0x18F02D05, true, {0x00, 0x7D, 0x9C, 0x7C, 0xD5, 0x80, 0xFF, 0xFF}), m) ==
            Status::kOk);
    REQUIRE(m.force);
    CHECK_FALSE(m.rate);
    CHECK((*m.force - Eigen::Vector3d(0.0, -1.0, 9.81)).norm() < 1e-12);
    // The ends of the valid range, and J1939's "error" and "not available".
    CHECK(decoder.decode(test::make_frame(0x0CF02A80, true, {0, 0, 0xFF, 0xFA, 0, 0, 0, 0}), m) == Status::kOk);
    CHECK(decoder.decode(test::make_frame(0x0CF02D80, true, {0, 0, 0xFF, 0xFA, 0, 0, 0, 0}), m) == Status::kOk);
    for (const int code : {0xFB, 0xFE, 0xFF}) {
        CHECK(decoder.decode(test::make_frame(0x0CF02A80, true, {0, 0, 0, code, 0, 0, 0, 0}), m) == Status::kCorrupt);
        CHECK(decoder.decode(test::make_frame(0x0CF02D80, true, {0, 0, 0, code, 0, 0, 0, 0}), m) == Status::kCorrupt);
    }
    CHECK(decoder.decode(test::make_frame(0x0CF02A80, true, {0, 0, 0, 0}), m) == Status::kCorrupt);
    CHECK(decoder.decode(test::make_frame(0x0CF02980, true, {0, 0, 0, 0, 0, 0, 0, 0}), m) == Status::kNotFound);
    CHECK(decoder.decode(test::make_frame(0x0CF02A80 & 0x7FF, false, {0, 0, 0, 0, 0, 0, 0, 0}), m) ==
          Status::kNotFound);
}

TEST_CASE("the slope message of the OpenIMU300 gives pitch and roll") {
    DbcFile file;
    std::string error;
    REQUIRE(file.parse(openimu300_dbc(), "openimu300", error) == Status::kOk);
    const DbcMessage& slope = *file.find("SlopeSensor2");
    // Pitch 10 deg = 260 * 32768 = 0x820000; roll -0.5 deg = 249.5 * 32768 = 0x7CC000.
    const CanFrame frame = test::make_frame(0x0CF02980, true, {0x00, 0x00, 0x82, 0x00, 0xC0, 0x7C, 0, 0});
    CHECK(slope.value(*slope.find("Pitch"), frame.data()).value() == Approx(10.0).epsilon(1e-12));
    CHECK(slope.value(*slope.find("Roll"), frame.data()).value() == Approx(-0.5).epsilon(1e-12));
    CHECK(slope.id == 0x0CF02980);
}

TEST_CASE("a source address restricts J1939 to one node, in decoder and kernel filter") {
    CanSignalMap map = openimu300_map();
    map.source_address = 0x81;
    DbcDecoder decoder = openimu(map);
    CanMeasurement m;
    CHECK(decoder.decode(test::make_frame(0x0CF02A80, true, {0, 0, 0, 0, 0, 0, 0, 0}), m) == Status::kNotFound);
    CHECK(decoder.decode(test::make_frame(0x0CF02A81, true, {0, 0, 0, 0, 0, 0, 0, 0}), m) == Status::kOk);
    const auto filters = decoder.filters();
    REQUIRE(filters.size() == 2);
    CHECK(filters[0].value == 0x0CF02A81);
    CHECK(filters[0].mask == 0x03FFFFFF);
    CHECK(filters[0].extended);
}

constexpr const char* kOneMessage = R"dbc(
BO_ 256 Imu: 16 N
 SG_ P M : 0|4@1+ (1,0) [0|0] "" N
 SG_ Wx m0 : 8|16@1- (1,0) [0|0] "mdps" N
 SG_ Wy m0 : 24|16@1- (1,0) [0|0] "mdps" N
 SG_ Wz m0 : 40|16@1- (1,0) [0|0] "mdps" N
 SG_ Ax m1 : 8|16@1- (1,0) [0|0] "mg" N
 SG_ Ay m1 : 24|16@1- (1,0) [0|0] "mg" N
 SG_ Az m1 : 40|16@1- (1,0) [0|0] "mg" N
 SG_ T : 64|8@1- (0.5,20) [0|0] "degC" N
 SG_ Count : 72|4@1+ (1,0) [0|0] "" N
 SG_ Odd : 80|8@1- (1,0) [0|0] "furlong" N
)dbc";

CanSignalMap one_message_map() {
    CanSignalMap map;
    map.rate = {{{"Imu", "Wx"}, {"Imu", "Wy"}, {"Imu", "Wz"}}};
    map.force = {{{"Imu", "Ax"}, {"Imu", "Ay"}, {"Imu", "Az"}}};
    map.temperature = {"Imu", "T"};
    map.counter = {"Imu", "Count"};
    return map;
}

TEST_CASE("one multiplexed message: units, temperature, lost frames by the counter") {
    DbcFile file;
    std::string error;
    REQUIRE(file.parse(kOneMessage, "one", error) == Status::kOk);
    DbcDecoder decoder;
    REQUIRE(decoder.configure(file, one_message_map(), error) == Status::kOk);
    CHECK(decoder.filters().size() == 1);
    const auto frame = [](int page, int count) {
        return test::make_frame(256, false, {page, 0xE8, 0x03, 0, 0, 0x18, 0xFC, 0, 10, count, 0, 0, 0, 0, 0, 0});
    };
    CanMeasurement m;
    REQUIRE(decoder.decode(frame(0, 14), m) == Status::kOk);
    CHECK((*m.rate - Eigen::Vector3d(kDeg, 0.0, -kDeg)).norm() < 1e-15);
    CHECK(m.temperature_c == 25.0);
    CHECK(m.lost == 0);
    REQUIRE(decoder.decode(frame(1, 14), m) == Status::kOk);
    CHECK_FALSE(m.rate);
    CHECK((*m.force - Eigen::Vector3d(9.80665, 0.0, -9.80665)).norm() < 1e-12);
    REQUIRE(decoder.decode(frame(0, 1), m) == Status::kOk);  // 15 and 0 are missing
    CHECK(m.lost == 2);
    CHECK(decoder.decode(frame(2, 1), m) == Status::kNotFound);
}

TEST_CASE("a map that does not fit the database is refused in words") {
    DbcFile file;
    std::string error;
    REQUIRE(file.parse(kOneMessage, "one", error) == Status::kOk);
    DbcDecoder decoder;
    CanSignalMap map = one_message_map();
    map.rate[0].message = "Gone";
    CHECK(decoder.configure(file, map, error) == Status::kInvalidArgument);
    CHECK(error == "angular rate: there is no message 'Gone' in the database");
    map = one_message_map();
    map.force[2].signal = "Aw";
    CHECK(decoder.configure(file, map, error) == Status::kInvalidArgument);
    CHECK(error == "specific force: there is no signal 'Aw' in message 'Imu'");
    map = one_message_map();
    map.force[1].signal = "Odd";
    CHECK(decoder.configure(file, map, error) == Status::kInvalidArgument);
    CHECK(error == "specific force: unit 'furlong' of signal 'Odd' is unknown");
    map = one_message_map();
    map.counter.signal = "Nope";
    CHECK(decoder.configure(file, map, error) == Status::kInvalidArgument);
    map = one_message_map();
    map.j1939 = true;
    CHECK(decoder.configure(file, map, error) == Status::kInvalidArgument);
    CHECK(error == "angular rate: message 'Imu' has no 29-bit identifier, which J1939 requires");
}

}  // namespace
}  // namespace facet::dbc_decoder_test
