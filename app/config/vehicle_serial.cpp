// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_serial.h"

#include <array>
#include <string_view>

#include "app/support/yaml_section.h"

namespace facet {

ImuSerialOptions read_imu_serial(const YamlNode& node) {
    ImuSerialOptions imu;
    YamlSection section(node);
    (void)section.at("protocol");
    constexpr std::array<std::string_view, 3> kSerialProtocols{"vectornav", "xsens", "microstrain"};
    imu.sensor = static_cast<SerialSensor>(section.choice("protocol", kSerialProtocols, 0));
    section.read("device", imu.device);
    section.read("baud", imu.baud, 9600, 4'000'000);
    section.finish();
    return imu;
}

}  // namespace facet
