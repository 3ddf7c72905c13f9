// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_iio.h"

#include <array>
#include <string_view>

#include "app/support/yaml_section.h"

namespace facet {
namespace {

/// Either one device, or one for each quantity.
void read_devices(YamlSection& section, ImuIioOptions& imu) {
    const auto device = section.find("device");
    const auto gyro = section.find("gyro");
    const auto accel = section.find("accel");
    const bool has_one = device && !gyro && !accel;
    const bool has_two = !device && gyro && accel;
    if (!has_one && !has_two) {
        section.node().fail("must have either 'device', or 'gyro' and 'accel'");
    }
    for (const auto& [field, name] :
         {std::pair{has_one ? device : gyro, &imu.gyro}, std::pair{has_one ? device : accel, &imu.accel}}) {
        *name = field->text();
        if (name->empty()) {
            field->fail("must not be empty");
        }
    }
}

void read_attributes(YamlSection& section, IioOptions& device) {
    const auto attributes = section.find("attributes");
    if (!attributes) {
        return;
    }
    YamlSection list(*attributes);
    for (const auto& item : attributes->raw()) {
        const std::string name = item.first.Scalar();
        const YamlNode value = list.at(name);
        if (name.empty() || name.find('/') != std::string::npos) {
            value.fail("is not an attribute of a device");
        }
        device.settings.push_back({name, value.text()});
    }
}

}  // namespace

ImuIioOptions read_imu_iio(const YamlNode& node, double rate_hz) {
    constexpr double kMostRate_hz = 10'000.0;
    constexpr int kMostScans = 32;  // of a burst that ImuAssembler keeps until the other device's comes
    ImuIioOptions imu;
    YamlSection section(node);
    read_devices(section, imu);
    section.read("trigger", imu.device.trigger);
    imu.device.rate_hz = rate_hz;
    section.read("rate_hz", imu.device.rate_hz, 0.0, kMostRate_hz);
    section.read("buffer_length", imu.device.buffer_length, 2, 4096);
    section.read("watermark", imu.device.watermark, 1, kMostScans);
    constexpr std::array<std::string_view, 2> kClocks{"monotonic", "realtime"};
    imu.device.clock = static_cast<IioClock>(section.choice("clock", kClocks, 0));
    constexpr std::array<std::string_view, 2> kStamps{"kernel", "arrival"};
    imu.stamps = static_cast<IioStamps>(section.choice("stamps", kStamps, 0));
    section.read("mount_matrix", imu.device.use_mount_matrix);
    read_attributes(section, imu.device);
    section.finish();
    if (imu.device.watermark > imu.device.buffer_length) {
        node.fail("watermark must not be above buffer_length");
    }
    return imu;
}

}  // namespace facet
