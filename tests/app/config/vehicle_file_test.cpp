// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_file.h"

#include <catch2/catch.hpp>
#include <string>

#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::vehicle_file_test {
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
const std::string kCameras = "cameras: {left: {device: /dev/video0}, right: {device: /dev/video2}}\n";
const std::string kImu = "imu: {spi: {chip: adis16448}}\n";

std::string example(const char* name) { return test::read_file(std::string(FACET_EXAMPLES) + "/" + name); }

TEST_CASE("a calibration of one camera makes a vehicle of one camera") {
    const test::TempDir dir;
    write_calibration(dir);
    const std::string identity = "  T_cam_imu: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
    dir.write("camchain.yaml", "cam0:\n" + std::string(kCamera) + identity);
    const Vehicle v =
        load_vehicle(dir.write("vehicle.yaml", kHead + "cameras: {left: {device: /dev/video3}}\n" + kImu));
    CHECK_FALSE(v.calibration.rig.has_right);
    CHECK(v.cameras.left.capture.device == "/dev/video3");
    const std::string path = dir.write("two.yaml", kHead + kCameras + kImu);
    CHECK(test::input_error_text([&] { static_cast<void>(load_vehicle(path)); }).find("has one camera") !=
          std::string::npos);
}

TEST_CASE("the SPI example is a whole vehicle") {
    const test::TempDir dir;
    write_calibration(dir);
    const Vehicle v = load_vehicle(dir.write("vehicle.yaml", example("vehicle_spi.yaml")));
    CHECK(v.config.regularity.mode == RegularityMode::kSpr);
    CHECK(v.config.imu_noise.rate_hz == 200.0);
    CHECK(v.odometry.rate_hz == 50.0);
    CHECK(v.odometry.smoothing_s == 0.0);
    CHECK_FALSE(v.cameras.side_by_side);
    CHECK(v.cameras.left.capture.device == "/dev/video0");
    CHECK(v.cameras.right.capture.device == "/dev/video1");
    CHECK(v.cameras.right.capture.width == 160);
    CHECK(v.cameras.right.capture.height == 120);
    CHECK(v.cameras.left.exposure == Duration::from_seconds(0.004));
    REQUIRE(v.cameras.left.controls.size() == 2);
    CHECK(v.cameras.left.controls[1].name == "analogue_gain");
    CHECK(v.cameras.left.controls[1].value == 16);
    REQUIRE(v.trigger);
    CHECK(v.trigger->input.line.offset == 17);
    CHECK(v.trigger->input.input.rising);
    REQUIRE(v.imu_spi);
    CHECK_FALSE(v.imu_can);
    CHECK(v.imu_spi->chip == SpiChip::kAdis16);
    CHECK(v.imu_spi->adis16.model == Adis16Model::k16448);
    REQUIRE(v.imu_spi->data_ready);
    CHECK(v.imu_spi->data_ready->line.offset == 25);
    REQUIRE(v.mavlink);
    CHECK(v.mavlink->channel.serial == "/dev/ttyS1");
    CHECK(v.log.folder == "/var/lib/facet/log");
    CHECK(v.log.by_flight);
    CHECK(v.log.keep_mb == 4096);
    CHECK(v.realtime.lock_memory);
    CHECK(v.realtime.estimator.cpu == 3);
    CHECK(v.realtime.imu.priority == 45);
}

TEST_CASE("the CAN example is a whole vehicle, its paths beside the file") {
    const test::TempDir dir;
    write_calibration(dir);
    std::string text = example("vehicle_can.yaml");
    // The database and the map of the driver's own tests.
    const auto replace = [&](const std::string& from, const std::string& to) {
        const std::size_t at = text.find(from);
        REQUIRE(at != std::string::npos);
        text.replace(at, from.size(), to);
    };
    replace("dbc: imu.dbc", "dbc: two.dbc");
    dir.write("two.dbc",
              "BO_ 256 Gyro: 6 S\n SG_ GyroX : 0|16@1- (0.01,0) [0|0] \"deg/s\" V\n"
              " SG_ GyroY : 16|16@1- (0.01,0) [0|0] \"deg/s\" V\n SG_ GyroZ : 32|16@1- (0.01,0) [0|0] \"deg/s\" V\n\n"
              "BO_ 257 Accel: 6 S\n SG_ AccelX : 0|16@1- (0.01,0) [0|0] \"m/s^2\" V\n"
              " SG_ AccelY : 16|16@1- (0.01,0) [0|0] \"m/s^2\" V\n SG_ AccelZ : 32|16@1- (0.01,0) [0|0] \"m/s^2\" V\n");
    const Vehicle v = load_vehicle(dir.write("vehicle.yaml", text));
    CHECK(v.cameras.side_by_side);
    CHECK(v.cameras.left.capture.width == 320);
    CHECK_FALSE(v.trigger);
    REQUIRE(v.imu_can);
    CHECK(v.imu_can->protocol == CanProtocol::kDbc);
    CHECK(v.imu_can->source.latency == Duration::from_seconds(0.0005));
    CHECK(v.imu_can->source.axes.matrix()(2, 2) == -1.0);
    CHECK(v.log.folder == dir.file("log"));
    CHECK(v.realtime.estimator.cpu == -1);
    CHECK(v.log.mesh_faces == 200'000);
}

TEST_CASE("the example with the flight controller's IMU is a whole vehicle") {
    const test::TempDir dir;
    write_calibration(dir);
    const Vehicle v = load_vehicle(dir.write("vehicle.yaml", example("vehicle_mavlink.yaml")));
    REQUIRE(v.imu_mavlink);
    CHECK_FALSE(v.imu_can);
    CHECK_FALSE(v.imu_spi);
    CHECK(v.imu_mavlink->message == MavlinkImuMessage::kHighresImu);
    CHECK(v.imu_mavlink->rate_hz == 200.0);
    CHECK(v.imu_mavlink->silence == Duration::from_seconds(0.25));
    REQUIRE(v.mavlink);
    CHECK(v.mavlink->channel.serial == "/dev/ttyS1");
}

TEST_CASE("the example with a sensor of the kernel's is a whole vehicle") {
    const test::TempDir dir;
    write_calibration(dir);
    const Vehicle v = load_vehicle(dir.write("vehicle.yaml", example("vehicle_iio.yaml")));
    REQUIRE(v.imu_iio);
    CHECK_FALSE(v.imu_spi);
    CHECK(v.imu_iio->gyro == "icm42600-gyro");
    CHECK(v.imu_iio->accel == "icm42600-accel");
    CHECK(v.imu_iio->device.rate_hz == 200.0);
    CHECK(v.imu_iio->latency == Duration::from_seconds(0.002));
    CHECK(v.imu_iio->silence == Duration::from_seconds(0.1));
    REQUIRE(v.imu_iio->device.settings.size() == 2);
    CHECK(v.imu_iio->device.settings[1].name == "in_accel_scale");
    CHECK(v.imu_iio->device.settings[1].value == "0.004788403");
}

TEST_CASE("cameras have any format that fits, and their rate unless something triggers them") {
    const test::TempDir dir;
    write_calibration(dir);
    const auto load = [&](const std::string& text) {
        return load_vehicle(dir.write("v.yaml", kHead + text + kImu)).cameras;
    };
    const VehicleCameras usual = load("cameras: {rate_hz: 30}\n");
    CHECK(usual.left.capture.any_format);
    CHECK_FALSE(usual.left.capture.has_two_views);
    CHECK(usual.right.capture.rate_hz == 30.0);
    CHECK(load("cameras: {format: auto}\n").left.capture.any_format);
    const VehicleCameras both = load("cameras: {side_by_side: {device: /dev/video2, format: Y8I}}\n");
    CHECK_FALSE(both.left.capture.any_format);
    CHECK(both.left.capture.has_two_views);
    CHECK(both.left.capture.format == PixelFormat::kY8i);
    CHECK(both.left.capture.width == 320);
    const VehicleCameras triggered = load("cameras: {rate_hz: 30}\ntrigger: {line: 3}\n");
    CHECK(triggered.left.capture.rate_hz == 0.0);
}

TEST_CASE("the shortest vehicle files of the bring-up are whole vehicles") {
    const test::TempDir dir;
    write_calibration(dir);
    const std::string document = test::read_file(FACET_BRING_UP);
    const std::string begin = "```\ncalibration: ";
    int files = 0;
    for (std::size_t at = document.find(begin); at != std::string::npos; at = document.find(begin, at + 1)) {
        const std::size_t from = at + 4;
        const std::string text = document.substr(from, document.find("```", from) - from);
        const bool is_ros2 = text.find("ros2") != std::string::npos;
        if (is_ros2 && !has_ros2()) {
            continue;
        }
        const Vehicle v = load_vehicle(dir.write("v.yaml", text));
        CHECK(v.mavlink);
        CHECK(v.imu_mavlink.has_value() != is_ros2);
        CHECK(v.imu_ros2.has_value() == is_ros2);
        CHECK(v.cameras.side_by_side != is_ros2);
        CHECK(v.cameras.rate_hz == 30.0);
        CHECK((is_ros2 || v.cameras.left.capture.rate_hz == 30.0));
        ++files;
    }
    CHECK(files == (has_ros2() ? 3 : 2));
}

TEST_CASE("the flight controller's IMU has options, and needs the link") {
    const test::TempDir dir;
    write_calibration(dir);
    const auto load = [&](const std::string& imu, const std::string& sinks) {
        return load_vehicle(dir.write(
            "v.yaml", kHead + kCameras + "imu: {axes: \"y -x z\", latency_s: 0.002, mavlink: " + imu + "}\n" + sinks));
    };
    const std::string link = "sinks: {mavlink: {}}\n";
    const Vehicle usual = load("{}", link);
    REQUIRE(usual.imu_mavlink);
    CHECK(usual.imu_mavlink->rate_hz == usual.calibration.noise.rate_hz);
    CHECK(usual.imu_mavlink->latency == Duration::from_seconds(0.002));
    CHECK(usual.imu_mavlink->axes.matrix()(0, 1) == 1.0);
    const Vehicle all = load("{message: raw_imu, rate_hz: 100, id: 1, gyro_filter_hz: 20, accel_filter_hz: 10}", link);
    CHECK(all.imu_mavlink->message == MavlinkImuMessage::kRawImu);
    CHECK(all.imu_mavlink->rate_hz == 100.0);
    CHECK(all.imu_mavlink->id == 1);
    CHECK(all.imu_mavlink->gyro_filter_hz == 20.0);
    CHECK(all.imu_mavlink->accel_filter_hz == 10.0);
    CHECK_THROWS_WITH(load("{}", ""), Catch::Contains("imu.mavlink needs sinks.mavlink"));
    CHECK_THROWS_WITH(load("{message: attitude}", link), Catch::Contains("message"));
    CHECK_THROWS_WITH(load("{rate_hz: 5}", link), Catch::Contains("rate_hz"));
    CHECK_THROWS_WITH(load("{gyro_filter_hz: 0.5}", link), Catch::Contains("1 Hz at least"));
    CHECK_THROWS_WITH(load("{}, can: {}", link),
                      Catch::Contains("must have one of 'spi', 'can', 'iio', 'serial', 'mavlink' and 'ros2'"));
}

TEST_CASE("a vehicle file needs calibration, cameras and an IMU, and has defaults for the rest") {
    const test::TempDir dir;
    write_calibration(dir);
    const Vehicle v = load_vehicle(dir.write("v.yaml", kHead + kCameras + "imu: {can: {decoder: openimu300}}\n"));
    CHECK(v.cameras.rate_hz == 20.0);
    CHECK(v.cameras.left.capture.format == PixelFormat::kGrey);
    REQUIRE(v.imu_can);
    CHECK(v.imu_can->source.socket.interface == "can0");
    CHECK_FALSE(v.mavlink);
    CHECK(v.log.folder.empty());
    CHECK_FALSE(v.realtime.lock_memory);
}

TEST_CASE("the link to the flight controller has options, and defaults that fit most vehicles") {
    const test::TempDir dir;
    write_calibration(dir);
    const auto load = [&](const std::string& mavlink) {
        return load_vehicle(dir.write("v.yaml", kHead + kCameras + kImu + "sinks: {mavlink: " + mavlink + "}\n"));
    };
    const Vehicle usual = load("{serial: /dev/ttyS1}");
    REQUIRE(usual.mavlink);
    CHECK(usual.mavlink->address == MavlinkAddress{1, 197});
    CHECK(usual.mavlink->message == PoseMessage::kOdometry);
    CHECK(usual.mavlink->time == MavlinkTime::kAutopilot);
    CHECK(usual.mavlink->commands_from == 0);
    CHECK_FALSE(usual.mavlink->send_lost);
    CHECK_FALSE(usual.mavlink->in_map);
    CHECK_FALSE(usual.mavlink->signing);
    CHECK_FALSE(usual.obstacles);
    dir.write("link.key", "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1eFF\n");
    const Vehicle other = load(
        "{udp_port: 14580, udp_local_port: 14540, system: 7, component: 198, autopilot_component: 2, time: own, "
        "commands_from: 255, message: vision_position_estimate, frame: map, send_lost: true, "
        "signing: {key_file: link.key, link: 4, accept_unsigned: true}, obstacles: {max_range_m: 20, rate_hz: 5}, "
        "origin: {latitude_deg: 47.4, longitude_deg: 8.5}}");
    REQUIRE(other.mavlink);
    const MavlinkOptions& o = *other.mavlink;
    CHECK(o.address == MavlinkAddress{7, 198});
    CHECK(o.channel.udp_port == 14580);
    CHECK(o.channel.udp_local_port == 14540);
    CHECK(o.autopilot_component == 2);
    CHECK(o.time == MavlinkTime::kOwn);
    CHECK(o.commands_from == 255);
    CHECK(o.message == PoseMessage::kVision);
    CHECK(o.send_lost);
    REQUIRE(o.signing);
    CHECK(o.signing->key[1] == 1);
    CHECK(o.signing->key[31] == 255);
    CHECK(o.signing->link == 4);
    CHECK(o.signing->accept_unsigned);
    REQUIRE(other.mavlink->origin);
    CHECK(other.mavlink->origin->latitude_deg == 47.4);
    CHECK(other.mavlink->origin->altitude_m == 0.0);
    REQUIRE(other.obstacles);
    CHECK(other.obstacles->max_range_m == 20.0);
    CHECK(other.obstacles->rate_hz == 5.0);
    CHECK(other.obstacles->below_m == 0.5);
}

TEST_CASE("exposure and gain may be left to the images, on the sensors' own nodes") {
    const test::TempDir dir;
    write_calibration(dir);
    const auto load = [&](const std::string& cameras) {
        return load_vehicle(dir.write("v.yaml", kHead + "cameras: {" + cameras + "}\n" + kImu));
    };
    CHECK_FALSE(load("rate_hz: 20").cameras.auto_exposure);
    const VehicleCameras cameras =
        load(
            "format: Y012, msb_aligned: true, left: {device: /dev/video0, controls_device: /dev/v4l-subdev1}, "
            "right: {device: /dev/video1}, auto_exposure: {exposure_step_s: 1e-5, most_exposure: 400, gain_one: 16, "
            "most_gain: 64, target: 100}")
            .cameras;
    CHECK(cameras.left.capture.format == PixelFormat::kY012);
    CHECK(cameras.left.msb_aligned);
    CHECK(cameras.left.controls_device == "/dev/v4l-subdev1");
    CHECK(cameras.right.controls_device.empty());
    REQUIRE(cameras.auto_exposure);
    CHECK(cameras.auto_exposure->exposure_step_s == 1e-5);
    CHECK(cameras.auto_exposure->least_gain == 16);
    CHECK(cameras.auto_exposure->most_gain == 64);
    CHECK(cameras.auto_exposure->most_exposure == 400);
    CHECK(cameras.auto_exposure->exposure_control == "exposure");
    const auto refused = [&](const std::string& automatic) {
        return test::input_error_text([&] { (void)load("auto_exposure: " + automatic); });
    };
    CHECK(refused("{most_exposure: 4}").find("exposure_step_s: missing") != std::string::npos);
    CHECK(refused("{exposure_step_s: 1e-5, most_exposure: 4, least_exposure: 9}").find("most_exposure") !=
          std::string::npos);
}

TEST_CASE("a socket for planners has a path, a group and a mode") {
    const test::TempDir dir;
    write_calibration(dir);
    const auto load = [&](const std::string& world) {
        return load_vehicle(dir.write("v.yaml", kHead + kCameras + kImu + "sinks: {world: " + world + "}\n"));
    };
    const Vehicle usual = load("{path: /run/facet/world}");
    REQUIRE(usual.world);
    CHECK(usual.world->path == "/run/facet/world");
    CHECK(usual.world->group.empty());
    CHECK(usual.world->mode == 0660);
    const Vehicle other = load("{path: /run/p, group: planner, mode: 666}");
    CHECK(other.world->group == "planner");
    CHECK(other.world->mode == 0666);
    CHECK(load("{path: /run/p, mode: 0600}").world->mode == 0600);
}

TEST_CASE("the reported body may be another frame than the IMU's") {
    const test::TempDir dir;
    write_calibration(dir);
    const auto load = [&](const std::string& body) {
        return load_vehicle(dir.write("v.yaml", kHead + kCameras + kImu + "sinks: {T_body_imu: " + body + "}\n"));
    };
    const Se3 given = load("{place_m: [0.1, 0, -0.02], rpy_deg: [0, 90, 90]}").odometry.T_body_imu;
    CHECK(given.p.isApprox(Eigen::Vector3d(0.1, 0.0, -0.02)));
    // Pitched nose down, then turned to the left: the IMU's x axis points down, its z axis ahead and then left.
    CHECK((given.q * Eigen::Vector3d::UnitX()).isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
    CHECK((given.q * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
    const Se3 rows = load("[[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]").odometry.T_body_imu;
    CHECK(rows.p.isApprox(Eigen::Vector3d(1.0, 2.0, 3.0)));
    CHECK((rows.q * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
    CHECK(load("{}").odometry.T_body_imu.p.isZero(0.0));
    const auto refused = [&](const std::string& body) { return test::input_error_text([&] { (void)load(body); }); };
    CHECK(refused("{place_m: [0, 0]}").find("T_body_imu.place_m") != std::string::npos);
    CHECK(refused("{place_m: [0, 0, 1000]}").find("within 100 m") != std::string::npos);
    CHECK(refused("{place: [0, 0, 1]}").find("sinks.T_body_imu") != std::string::npos);
    CHECK(refused("[[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]").find("reflection") != std::string::npos);
}

TEST_CASE("estimates may go onto a CAN bus, that of the IMU or another") {
    const test::TempDir dir;
    write_calibration(dir);
    const auto load = [&](const std::string& imu, const std::string& can) {
        return load_vehicle(dir.write("v.yaml", kHead + kCameras + imu + "sinks: {can: " + can + "}\n"));
    };
    const std::string node = "imu: {can: {decoder: dronecan, node_id: 42}}\n";
    const Vehicle usual = load(kImu, "{interface: can1}");
    REQUIRE(usual.can_out);
    CHECK(usual.can_out->interface == "can1");
    CHECK(usual.can_out->format == CanOutFormat::kAuto);
    CHECK(usual.can_out->first_id == 0x3A0);
    CHECK(usual.can_out->node_id == 0);
    const Vehicle other = load(node,
                               "{interface: can0, format: fd, bit_rate_switch: false, first_id: 0x100, every: 5, "
                               "send_lost: true, dronecan_node_id: 43}");
    REQUIRE(other.can_out);
    CHECK(other.can_out->format == CanOutFormat::kFd);
    CHECK_FALSE(other.can_out->bit_rate_switch);
    CHECK(other.can_out->first_id == 0x100);
    CHECK(other.can_out->every == 5);
    CHECK(other.can_out->send_lost);
    CHECK(other.can_out->node_id == 43);
    const auto refused = [&](const std::string& can) { return test::input_error_text([&] { (void)load(node, can); }); };
    CHECK(refused("{}").find("sinks.can.interface: missing") != std::string::npos);
    CHECK(refused("{interface: can0, first_id: 0x7F8}").find("sinks.can.first_id") != std::string::npos);
    CHECK(refused("{interface: can0, dronecan_node_id: 42}").find("is that of the IMU") != std::string::npos);
    CHECK(load(node, "{interface: can1, dronecan_node_id: 42}").can_out);
}

TEST_CASE("trigger pulses come from a PWM or a line, at the cameras' rate") {
    const test::TempDir dir;
    write_calibration(dir);
    const auto load = [&](const std::string& pulses) {
        return load_vehicle(dir.write("v.yaml", kHead + "cameras: {rate_hz: 25}\n" + kImu + pulses));
    };
    CHECK_FALSE(load("").pulses);
    CHECK(load("").cameras.lag_frames == 0);
    const Vehicle pwm = load("trigger_output: {width_s: 0.002, pwm: {chip: /sys/class/pwm/pwmchip2, channel: 1}}\n");
    REQUIRE(pwm.pulses);
    CHECK(pwm.pulses->pulse.period == Duration::from_seconds(0.04));
    CHECK(pwm.pulses->pulse.width == Duration::from_seconds(0.002));
    CHECK(pwm.pulses->pwm_chip == "/sys/class/pwm/pwmchip2");
    CHECK(pwm.pulses->pwm_channel == 1);
    const Vehicle gpio = load("trigger_output: {gpio: {chip: /dev/gpiochip1, line: EXPOSE}}\n");
    REQUIRE(gpio.pulses);
    CHECK(gpio.pulses->pwm_chip.empty());
    CHECK(gpio.pulses->line.chip == "/dev/gpiochip1");
    CHECK(gpio.pulses->line.name == "EXPOSE");
    CHECK(gpio.pulses->line.backend == GpioBackend::kAuto);
    CHECK(load("trigger_output: {gpio: {line: 3, backend: chardev}}\n").pulses->line.backend == GpioBackend::kChardev);
}

TEST_CASE("a mistake in a vehicle file is one line with file, line and field") {
    const test::TempDir dir;
    write_calibration(dir);
    const struct {
        std::string text;
        std::string complaint;
    } cases[] = {
        {"cameras: {}\n", ":1: calibration: missing"},
        {kHead + kImu, ":1: cameras: missing"},
        {kHead + kCameras, ":1: imu: missing"},
        {kHead + kCameras + "imu: {}\n",
         ":3: imu: must have one of 'spi', 'can', 'iio', 'serial', 'mavlink' and 'ros2'"},
        {kHead + kCameras + kImu + "tirgger: {}\n",
         ":4: tirgger: unknown key; there are: calibration, estimator, cameras, trigger, trigger_output, imu, ros2, "
         "sinks, "
         "realtime"},
        {kHead + "cameras:\n  rate_hz: fast\n" + kImu, ":3: cameras.rate_hz: must be a number"},
        {kHead + "cameras:\n  rate_hz: 0\n" + kImu, ":3: cameras.rate_hz: must be within [1, 200], is 0"},
        {kHead + "cameras:\n  format: H264\n" + kImu,
         ":3: cameras.format: 'H264' is unknown; one of: auto, GREY, Y10, Y10P, Y12, Y012, Y16, YUYV, UYVY, NV12, "
         "Y8I, Y12I, MJPG"},
        {kHead + "cameras: {format: Y8I}\n" + kImu,
         ":2: cameras: Y8I holds both views in one image: say 'side_by_side'"},
        {kHead + "cameras:\n  left: {devise: x}\n" + kImu, ":3: cameras.left.devise: unknown key"},
        {kHead + "cameras:\n  left: {}\n  side_by_side: {}\n" + kImu, ":2: cameras: has 'side_by_side' and 'left'"},
        {kHead + "cameras: {right: {device: /dev/video0}}\n" + kImu, ":2: cameras: left and right are the same device"},
        {kHead + kCameras + "imu: {spi: {chip: mpu6000}}\n",
         ":3: imu.spi.chip: 'mpu6000' is unknown; one of: adis16448"},
        {kHead + kCameras + "imu:\n  axes: x y -z\n  spi: {chip: bmi088}\n",
         ":4: imu.axes: 'x y -z' is not an axis map"},
        {kHead + kCameras + "imu: {spi: {chip: icm42688, rate_hz: 300}}\n",
         ":3: imu.spi.rate_hz: is 300; one of: 200, 500, 1000, 2000"},
        {kHead + kCameras + "imu: {spi: {chip: bmi088, data_ready: {line: 2, chip: c, clock: hardware}}}\n",
         ":3: imu.spi.data_ready: clock must be monotonic or realtime"},
        {kHead + kCameras + "imu: {can: {interface: can0}}\n", ":3: imu.can.decoder: missing"},
        {kHead + kCameras + "imu: {can: {decoder: dbc, dbc: no.dbc, map: {}}}\n", "no.dbc: cannot be read"},
        {kHead + kCameras + kImu + "trigger: {chip: /dev/gpiochip0}\n", ":4: trigger.line: missing"},
        {kHead + kCameras + kImu + "trigger: {line: -2}\n", ":4: trigger.line: must not be negative"},
        {kHead + kCameras + kImu + "trigger: {line: 2, backend: sysfs}\n",
         ":4: trigger.backend: 'sysfs' is unknown; one of: auto, libgpiod, chardev"},
        {kHead + kCameras + kImu + "trigger_output: {width_s: 0.001}\n",
         ":4: trigger_output: must have either 'pwm' or 'gpio'"},
        {kHead + kCameras + kImu + "trigger_output: {width_s: 0.06, pwm: {}}\n",
         ":4: trigger_output: width_s must be below 0.05, the period of cameras.rate_hz"},
        {kHead + kCameras + kImu + "trigger_output: {gpio: {chip: /dev/gpiochip0}}\n",
         ":4: trigger_output.gpio.line: missing"},
        {kHead + kCameras + kImu + "trigger_output: {pwm: {channel: -1}}\n",
         ":4: trigger_output.pwm.channel: must be within [0, 63], is -1"},
        {kHead + kCameras + kImu + "sinks: {mavlink: {serial: /dev/ttyS0, udp_port: 1}}\n",
         ":4: sinks.mavlink: has both 'serial'"},
        {kHead + kCameras + kImu + "sinks:\n  mavlink:\n    time: gps\n",
         ":6: sinks.mavlink.time: 'gps' is unknown; one of: autopilot, own"},
        {kHead + kCameras + kImu + "sinks: {mavlink: {commands_from: 256}}\n",
         ":4: sinks.mavlink.commands_from: must be within [0, 255], is 256"},
        {kHead + kCameras + kImu + "sinks: {mavlink: {origin: {latitude_deg: 91, longitude_deg: 0}}}\n",
         ":4: sinks.mavlink.origin.latitude_deg: must be within [-90, 90], is 91"},
        {kHead + kCameras + kImu + "sinks: {mavlink: {obstacles: {max_range_m: 0}}}\n",
         ":4: sinks.mavlink.obstacles.max_range_m: must be within [1, 100], is 0"},
        {kHead + kCameras + kImu + "sinks: {mavlink: {signing: {link: 1}}}\n",
         ":4: sinks.mavlink.signing.key_file: missing"},
        {kHead + kCameras + kImu + "sinks: {mavlink: {signing: {key_file: imu.yaml}}}\n",
         "imu.yaml: must hold 64 hexadecimal digits"},
        {kHead + kCameras + kImu + "sinks: {mavlink: {signing: {key_file: no.key}}}\n", "no.key: cannot be read"},
        {kHead + kCameras + kImu + "sinks: {log: {}}\n", ":4: sinks.log.folder: missing"},
        {kHead + kCameras + kImu + "sinks: {world: {}}\n", ":4: sinks.world.path: missing"},
        {kHead + kCameras + kImu + "sinks: {world: {path: w, mode: 0888}}\n",
         ":4: sinks.world: mode must be octal digits up to 0777, such as 0660"},
        {kHead + kCameras + kImu + "sinks: {world: {path: w, mode: 1777}}\n",
         ":4: sinks.world: mode must be octal digits up to 0777, such as 0660"},
        {kHead + kCameras + kImu + "realtime: {lock_memory: 3}\n", ":4: realtime.lock_memory: must be true or false"},
        {kHead + kCameras + kImu + "realtime: {threads: {imu: {priority: 100}}}\n",
         ":4: realtime.threads.imu.priority: must be within [0, 99], is 100"},
        {kHead + kCameras + kImu + "estimator: {mode: x}\n", ":4: estimator.mode: 'x' is unknown; one of: s, sp, spr"},
        {kHead + kCameras + kImu + "realtime: fast\n", ":4: realtime: must be a map of keys to values"},
        {"calibration: {euroc: ., imu: imu.yaml}\n" + kCameras + kImu, ":1: calibration: must have either 'euroc'"},
        {"calibration: {euroc: nowhere}\n" + kCameras + kImu, "cam0/sensor.yaml: cannot be read"},
    };
    for (const auto& c : cases) {
        const std::string path = dir.write("v.yaml", c.text);
        const std::string error = test::input_error_text([&] { (void)load_vehicle(path); });
        INFO(error);
        INFO(c.complaint);
        CHECK(error.find(c.complaint) != std::string::npos);
        CHECK(error.find('\n') == std::string::npos);
    }
}

TEST_CASE("a parameter that cannot be used is named with the file it is from") {
    const test::TempDir dir;
    write_calibration(dir);
    const std::string vehicle = dir.write("v.yaml", kHead + kCameras + kImu + "estimator: {config: parameters.yaml}\n");
    const auto error = [&] { return test::input_error_text([&] { (void)load_vehicle(vehicle); }); };
    const std::string parameters = dir.write("parameters.yaml", "mesh:\n  max_depth_m: 200\n");
    CHECK(error() == parameters + ":2: mesh.max_depth_m: must be within [0.5, 100] m, is 200");
    dir.write("parameters.yaml", "frontend:\n  window_px: 16\n");
    CHECK(error() == vehicle + ": frontend: window_px must be odd");
    dir.write("parameters.yaml", "mesh: {}\n");
    CHECK(error() == "no error");
    std::string imu = test::read_file(dir.file("imu.yaml"));
    imu.replace(imu.find("200"), 3, "2");
    dir.write("imu.yaml", imu);
    CHECK(error() == dir.file("imu.yaml") + ":5: update_rate: must be within [20, 10000] Hz, is 2");
}

}  // namespace
}  // namespace facet::vehicle_file_test
