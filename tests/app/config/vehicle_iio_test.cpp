// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_iio.h"

#include <yaml-cpp/yaml.h>

#include <catch2/catch.hpp>

namespace facet::vehicle_iio_test {
namespace {

TEST_CASE("a sensor of the kernel's is one device or two, with what is asked of them") {
    const auto load = [](const std::string& iio) {
        return read_imu_iio(YamlNode(YAML::Load(iio), "v.yaml", "imu.iio", YamlNode::kNoLine), 200.0);
    };
    const ImuIioOptions one = load(
        "{device: imu, trigger: timer, rate_hz: 0, buffer_length: 64, watermark: 4, clock: realtime, "
        "stamps: arrival, mount_matrix: false}");
    CHECK(one.gyro == "imu");
    CHECK(one.accel == "imu");
    CHECK(one.device.trigger == "timer");
    CHECK(one.device.rate_hz == 0.0);
    CHECK(one.device.buffer_length == 64);
    CHECK(one.device.watermark == 4);
    CHECK(one.device.clock == IioClock::kRealtime);
    CHECK(one.stamps == IioStamps::kArrival);
    CHECK_FALSE(one.device.use_mount_matrix);
    const std::string both = "must have either 'device', or 'gyro' and 'accel'";
    CHECK_THROWS_WITH(load("{}"), Catch::Contains("imu.iio: " + both));
    CHECK_THROWS_WITH(load("{gyro: g}"), Catch::Contains(both));
    CHECK_THROWS_WITH(load("{device: d, gyro: g, accel: a}"), Catch::Contains(both));
    CHECK_THROWS_WITH(load("{device: ''}"), Catch::Contains("imu.iio.device: must not be empty"));
    CHECK_THROWS_WITH(load("{device: d, buffer_length: 2, watermark: 3}"), Catch::Contains("watermark must not be"));
    CHECK_THROWS_WITH(load("{device: d, attributes: {../../x: 1}}"),
                      Catch::Contains("is not an attribute of a device"));
    CHECK_THROWS_WITH(load("{device: d, clock: tai}"), Catch::Contains("imu.iio.clock: 'tai' is unknown"));
}

}  // namespace
}  // namespace facet::vehicle_iio_test
