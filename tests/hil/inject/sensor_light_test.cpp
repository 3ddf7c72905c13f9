// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/sensor_light.h"

#include <catch2/catch.hpp>

namespace facet::hil::sensor_light_test {
namespace {

const std::vector<std::uint8_t> kImage{10, 20, 30, 40, 50};

TEST_CASE("what is set between two edges is in force from the frame after the second") {
    SensorLight light({});
    light.at_edge(0, ExposureControls{});
    light.at_edge(0, ExposureControls{20, 4});
    CHECK(light.exposure(0) == Duration::from_seconds(0.004));
    CHECK(light.next_exposure(0) == Duration::from_seconds(0.002));
    CHECK(light.image(0, kImage, {}, 1.0)[4] == 50);
    light.at_edge(0, std::nullopt);  // unplugged: it keeps them
    CHECK(light.exposure(0) == Duration::from_seconds(0.002));
    CHECK(light.image(0, kImage, {}, 1.0)[4] == 100);
    CHECK(light.grey(0).median == 60);
    CHECK(light.grey(0).bright == 100);
    CHECK(light.image(1, kImage, {}, 1.0)[4] == 50);  // the other camera has its own
}

TEST_CASE("light swings by its factor either way, and what is too bright saturates") {
    SensorLight light({8.0, 60.0});
    CHECK(light.image(0, kImage, Duration::from_seconds(15.0), 1.0)[0] == 80);
    CHECK(light.image(0, kImage, Duration::from_seconds(15.0), 1.0)[4] == 255);
    CHECK(light.image(0, kImage, Duration::from_seconds(45.0), 1.0)[3] == 5);
    CHECK(light.image(0, kImage, Duration::from_seconds(60.0), 0.1)[3] == 4);
}

}  // namespace
}  // namespace facet::hil::sensor_light_test
