// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/service_drop_in.h"

#include <catch2/catch.hpp>

#include "app/config/vehicle_files.h"
#include "tests/support/temp_dir.h"

namespace facet::service_drop_in_test {
namespace {

Vehicle spi_vehicle() {
    Vehicle vehicle;
    vehicle.source = "vehicle.yaml";
    vehicle.trigger.emplace();
    vehicle.trigger->input.line.chip = "/dev/gpiochip1";
    vehicle.imu_spi.emplace();
    vehicle.imu_spi->device = "/dev/spidev1.0";
    vehicle.imu_spi->data_ready.emplace();
    vehicle.imu_spi->data_ready->line.chip = "/dev/gpiochip0";
    vehicle.mavlink.emplace();
    vehicle.mavlink->channel.serial = "/dev/ttyAMA1";
    vehicle.log.folder = "/var/lib/facet/log";
    return vehicle;
}

bool has(const std::string& text, const std::string& line) { return text.find(line + "\n") != std::string::npos; }

TEST_CASE("the service may use the devices that the vehicle file names, and no others") {
    CHECK(service_drop_in(spi_vehicle()) ==
          "# Made by facet check-config --drop-in of vehicle.yaml: rights of the devices and addresses that it names.\n"
          "[Service]\n"
          "DeviceAllow=\n"
          "DeviceAllow=/dev/gpiochip0 rw\n"
          "DeviceAllow=/dev/gpiochip1 rw\n"
          "DeviceAllow=/dev/spidev1.0 rw\n"
          "DeviceAllow=/dev/ttyAMA1 rw\n"
          "DeviceAllow=char-media rw\n"
          "DeviceAllow=char-video4linux rw\n");
    Vehicle vehicle = spi_vehicle();
    vehicle.imu_spi->chip = SpiChip::kBmi088;
    vehicle.imu_spi->accel_device = "/dev/spidev1.1";
    vehicle.mavlink->channel.serial = "/dev/ttyUSB0";
    vehicle.cameras.left.capture.heap = vehicle.cameras.right.capture.heap = "/dev/dma_heap/linux,cma";
    const std::string text = service_drop_in(vehicle);
    CHECK(has(text, "DeviceAllow=/dev/spidev1.1 rw"));
    CHECK(has(text, "DeviceAllow=/dev/dma_heap/linux,cma rw"));
    CHECK(has(text, "DeviceAllow=char-ttyUSB rw"));  // plugged in again it may be ttyUSB1
}

TEST_CASE("the service may read an inertial sensor's serial line") {
    Vehicle vehicle = spi_vehicle();
    vehicle.imu_spi.reset();
    vehicle.imu_serial.emplace().device = "/dev/ttyACM0";
    CHECK(has(service_drop_in(vehicle), "DeviceAllow=char-ttyACM rw"));
}

TEST_CASE("the service may set up a sensor of the kernel's") {
    Vehicle vehicle = spi_vehicle();
    vehicle.imu_spi.reset();
    vehicle.imu_iio.emplace();
    const std::string text = service_drop_in(vehicle);
    CHECK(has(text, "DeviceAllow=char-iio rw"));
    CHECK(has(text, "ProtectKernelTunables=no"));
}

TEST_CASE("the service may talk to the flight controller's address") {
    Vehicle vehicle = spi_vehicle();
    vehicle.mavlink->channel.serial = "";
    vehicle.mavlink->channel.udp_host = "127.0.0.1";
    CHECK(service_drop_in(vehicle).find("IPAddressAllow") == std::string::npos);
    vehicle.mavlink->channel.udp_host = "10.41.1.1";
    CHECK(has(service_drop_in(vehicle), "IPAddressAllow=10.41.1.1"));
}

TEST_CASE("the service leaves this computer for ROS 2 only if an interface is named") {
    Vehicle vehicle = spi_vehicle();
    vehicle.ros2_out.emplace();
    CHECK(service_drop_in(vehicle).find("IPAddressAllow") == std::string::npos);
    vehicle.ros2.interfaces = {"lo", "eth0"};
    CHECK(has(service_drop_in(vehicle), "IPAddressAllow=any"));
    vehicle.ros2_out.reset();
    CHECK(service_drop_in(vehicle).find("IPAddressAllow") == std::string::npos);
}

TEST_CASE("a log folder elsewhere may be written, wherever the vehicle file is read") {
    Vehicle vehicle = spi_vehicle();
    vehicle.log.folder = "/data/flights";
    CHECK(has(service_drop_in(vehicle), "ReadWritePaths=-/data/flights"));
    vehicle.source = "/home/pilot/desk/vehicle.yaml";
    vehicle.log.folder = "/home/pilot/desk/log";  // beside the file
    CHECK(has(service_drop_in(vehicle), "ReadWritePaths=-/etc/facet/log"));
    vehicle.source = "vehicle.yaml";
    vehicle.log.folder = "log";
    CHECK(has(service_drop_in(vehicle), "ReadWritePaths=-/etc/facet/log"));
}

TEST_CASE("the planners' socket may be made where it is to be, and given to their group") {
    Vehicle vehicle = spi_vehicle();
    vehicle.world = VehicleWorld{"/run/facet/world", "", 0660};
    CHECK(service_drop_in(vehicle) == service_drop_in(spi_vehicle()));
    vehicle.world = VehicleWorld{"/run/planner/world", "planner", 0660};
    const std::string text = service_drop_in(vehicle);
    CHECK(has(text, "ReadWritePaths=-/run/planner"));
    CHECK(has(text, "SupplementaryGroups=planner"));
    CHECK(has(text, "SystemCallFilter=@chown"));
}

TEST_CASE("the files of a PWM channel go to the service's user before the start") {
    Vehicle vehicle = spi_vehicle();
    vehicle.pulses.emplace();
    vehicle.pulses->pwm_chip = "/sys/class/pwm/pwmchip2";
    vehicle.pulses->pwm_channel = 1;
    const std::string text = service_drop_in(vehicle);
    CHECK(has(text, "ProtectKernelTunables=no"));
    CHECK(has(text,
              "ExecStartPre=+/bin/sh -c '[ -d /sys/class/pwm/pwmchip2/pwm1 ] || echo 1 > "
              "/sys/class/pwm/pwmchip2/export; chown facet /sys/class/pwm/pwmchip2/pwm1/period "
              "/sys/class/pwm/pwmchip2/pwm1/duty_cycle /sys/class/pwm/pwmchip2/pwm1/enable'"));
    vehicle.pulses->pwm_chip = "";
    vehicle.pulses->line.chip = "/dev/gpiochip3";
    CHECK(has(service_drop_in(vehicle), "DeviceAllow=/dev/gpiochip3 rw"));
}

TEST_CASE("a percent sign or a dollar in a name does not become a specifier or a variable") {
    Vehicle vehicle = spi_vehicle();
    vehicle.log.folder = "/data/50%$HOME";
    CHECK(has(service_drop_in(vehicle), "ReadWritePaths=-/data/50%%$$HOME"));
}

TEST_CASE("the files that a vehicle file names are found, wherever they stand") {
    const test::TempDir dir;
    CHECK(files_named_by(dir.write("a.yaml",
                                   "calibration: {camchain: cal/camchain.yaml, imu: imu.yaml}\n"
                                   "estimator: {config: parameters.yaml}\n"
                                   "imu: {can: {decoder: dbc, dbc: imu.dbc}}\n"
                                   "sinks: {mavlink: {signing: {key_file: /etc/link.key}}}\n")) ==
          std::vector<std::string>{"cal/camchain.yaml", "imu.yaml", "parameters.yaml", "imu.dbc", "/etc/link.key"});
    CHECK(files_named_by(dir.write("b.yaml", "calibration: {euroc: rig}\nimu: {spi: {chip: bmi088}}\n")) ==
          std::vector<std::string>{"rig/cam0/sensor.yaml", "rig/cam1/sensor.yaml", "rig/imu0/sensor.yaml"});
    CHECK(files_named_by(dir.write("c.yaml", "cameras: {}\n")).empty());
}

}  // namespace
}  // namespace facet::service_drop_in_test
