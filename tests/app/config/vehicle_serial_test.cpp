// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_serial.h"

#include <yaml-cpp/yaml.h>

#include <catch2/catch.hpp>

namespace facet::vehicle_serial_test {
namespace {

TEST_CASE("an inertial sensor on a serial line needs its protocol only") {
    const auto load = [](const std::string& serial) {
        return read_imu_serial(YamlNode(YAML::Load(serial), "v.yaml", "imu.serial", YamlNode::kNoLine));
    };
    const ImuSerialOptions usual = load("{protocol: vectornav}");
    CHECK(usual.sensor == SerialSensor::kVectorNav);
    CHECK(usual.device == "/dev/ttyUSB0");
    CHECK(usual.baud == 115200);
    const ImuSerialOptions other = load("{protocol: microstrain, device: /dev/ttyACM1, baud: 921600}");
    CHECK(other.sensor == SerialSensor::kMicroStrain);
    CHECK(other.device == "/dev/ttyACM1");
    CHECK(other.baud == 921600);
    CHECK(load("{protocol: xsens}").sensor == SerialSensor::kXsens);
    CHECK_THROWS_WITH(load("{}"), Catch::Contains("imu.serial.protocol: missing"));
    CHECK_THROWS_WITH(load("{protocol: nmea}"),
                      Catch::Contains("'nmea' is unknown; one of: vectornav, xsens, microstrain"));
    CHECK_THROWS_WITH(load("{protocol: xsens, baud: 0}"), Catch::Contains("imu.serial.baud"));
}

}  // namespace
}  // namespace facet::vehicle_serial_test
