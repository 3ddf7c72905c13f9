// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_ros2.h"

#include <catch2/catch.hpp>
#include <string>

#include "app/config/vehicle_file.h"
#include "tests/support/temp_dir.h"

namespace facet::vehicle_ros2_test {
namespace {

constexpr const char* kCamera =
    "  camera_model: pinhole\n  intrinsics: [150, 150, 79.5, 59.5]\n  distortion_model: radtan\n"
    "  distortion_coeffs: [-0.1, 0.01, 0, 0]\n  resolution: [160, 120]\n";

void write_calibration(const test::TempDir& dir) {
    const std::string identity = "  T_cam_imu: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
    const std::string moved = "  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
    dir.write("camchain.yaml", "cam0:\n" + std::string(kCamera) + identity + "cam1:\n" + kCamera + moved);
    dir.write("imu.yaml",
              "gyroscope_noise_density: 1.7e-4\ngyroscope_random_walk: 1.9e-5\naccelerometer_noise_density: 2.0e-3\n"
              "accelerometer_random_walk: 3.0e-3\nupdate_rate: 200\n");
}

const std::string kHead = "calibration: {camchain: camchain.yaml, imu: imu.yaml}\n";
const std::string kImu = "imu: {spi: {chip: adis16448}}\n";

std::string example(const char* name) { return test::read_file(std::string(FACET_EXAMPLES) + "/" + name); }

TEST_CASE("the example with drivers of ROS 2 is a whole vehicle") {
    const test::TempDir dir;
    write_calibration(dir);
    const std::string path = dir.write("vehicle.yaml", example("vehicle_ros2.yaml"));
    if (!has_ros2()) {
        CHECK_THROWS_WITH(load_vehicle(path), Catch::Contains("built without ROS 2"));
        return;
    }
    const Vehicle v = load_vehicle(path);
    REQUIRE(v.cameras.ros2);
    CHECK(v.cameras.left_name() == "/camera/camera/infra1/image_rect_raw");
    CHECK(v.cameras.right_name() == "/camera/camera/infra2/image_rect_raw");
    CHECK(v.cameras.ros2->right.width == 160);
    CHECK(v.cameras.ros2->right.height == 120);
    CHECK(v.cameras.ros2->left.model.fx == 150.0);
    CHECK(v.cameras.ros2->left.silence == Duration::from_seconds(10.0 / 30.0));
    CHECK_FALSE(v.cameras.use_sequence);
    REQUIRE(v.imu_ros2);
    CHECK(v.imu_ros2->topic == "/camera/camera/imu");
    CHECK(v.imu_ros2->axes.matrix()(0, 2) == 1.0);
    CHECK(v.imu_ros2->silence == Duration::from_seconds(0.25));
    CHECK(v.ros2.domain == 0);
    CHECK(v.ros2.interfaces == std::vector<std::string>{"lo"});
    REQUIRE(v.ros2_out);
    CHECK(v.ros2_out->prefix == "/facet");
    CHECK(v.ros2_out->has_transform);
}

TEST_CASE("what is wrong with the keys of ROS 2 is said") {
    if (!has_ros2()) {
        return;
    }
    const test::TempDir dir;
    write_calibration(dir);
    const std::string topics = "cameras: {ros2: {left: /left/image, right: /right/image}}\n";
    const auto load = [&](const std::string& text) { return load_vehicle(dir.write("v.yaml", kHead + text)); };
    const auto fails = [&](const std::string& text, const std::string& words) {
        CHECK_THROWS_WITH(load(text), Catch::Contains(words));
    };
    CHECK(load(topics + "imu: {latency_s: 0.001, ros2: {topic: /imu}}\n").imu_ros2->latency.ns == 1'000'000);
    CHECK(load(topics + kImu + "ros2: {domain: 7, interfaces: [eth0, lo], peers: [10.0.0.2]}\n").ros2.domain == 7);
    fails(topics + "imu: {ros2: {}}\n", "topic");
    fails(topics + "imu: {ros2: {topic: imu}}\n", "must begin with /");
    fails("cameras: {ros2: {left: /left/image}}\n" + kImu, "must have 'right'");
    fails("cameras: {ros2: {left: /a, right: /a}}\n" + kImu, "is the topic of the left camera");
    fails("cameras: {format: GREY, ros2: {left: /a, right: /b}}\n" + kImu, "'format' is of cameras on nodes");
    fails("cameras: {left: {}, ros2: {left: /a, right: /b}}\n" + kImu, "'left' is of cameras on nodes");
    CHECK_FALSE(load(topics + kImu + "sinks: {ros2: {}}\n").ros2_out->has_grid);
    CHECK(load(topics + kImu + "sinks: {ros2: {grid: true}}\n").ros2_out->has_grid);
    fails(topics + kImu + "ros2: {domain: 233}\n", "domain");
    fails(topics + kImu + "ros2: {interfaces: []}\n", "must name one");
    fails(topics + kImu + "ros2: {interfaces: lo}\n", "must be a list");
    fails(topics + kImu + "ros2: {interface: lo}\n", "interface");
    fails(topics + kImu + "sinks: {ros2: {odom_frame: a, base_frame: a}}\n", "two names");
    fails(topics + kImu + "sinks: {ros2: {prefix: facet}}\n", "must begin with /");
}

}  // namespace
}  // namespace facet::vehicle_ros2_test
