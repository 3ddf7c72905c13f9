// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/service_drop_in.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>

namespace facet {
namespace {

/// What systemd reads twice: % begins a specifier, $ a variable.
std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        result += c == '%' || c == '$' ? std::string(2, c) : std::string(1, c);
    }
    return result;
}

/// Each once, in order.
std::set<std::string> devices_of(const Vehicle& vehicle) {
    std::set<std::string> devices{"char-media", "char-video4linux"};
    const auto add_line = [&](const GpioLineName& line) {
        if (!line.chip.empty()) {
            devices.insert(line.chip);
        }
    };
    for (const CameraV4l2Options* camera : {&vehicle.cameras.left, &vehicle.cameras.right}) {
        if (!camera->capture.heap.empty()) {
            devices.insert(camera->capture.heap);
        }
    }
    if (vehicle.trigger) {
        add_line(vehicle.trigger->input.line);
    }
    if (vehicle.pulses && vehicle.pulses->pwm_chip.empty()) {
        add_line(vehicle.pulses->line);
    }
    if (vehicle.imu_spi) {
        devices.insert(vehicle.imu_spi->device);
        if (vehicle.imu_spi->chip == SpiChip::kBmi088) {
            devices.insert(vehicle.imu_spi->accel_device);
        }
        if (vehicle.imu_spi->data_ready) {
            add_line(vehicle.imu_spi->data_ready->line);
        }
    }
    if (vehicle.imu_iio) {
        devices.insert("char-iio");  // plugged in again it may have another number
    }
    const auto add_serial = [&](const std::string& line) {
        devices.insert(line.starts_with("/dev/ttyUSB")   ? "char-ttyUSB"
                       : line.starts_with("/dev/ttyACM") ? "char-ttyACM"
                                                         : line);
    };
    if (vehicle.imu_serial) {
        add_serial(vehicle.imu_serial->device);
    }
    if (vehicle.mavlink && !vehicle.mavlink->channel.serial.empty()) {
        add_serial(vehicle.mavlink->channel.serial);
    }
    return devices;
}

/// Where a path beside the vehicle file lies once that file is /etc/facet/vehicle.yaml.
std::string on_vehicle(const std::string& path, const std::string& vehicle_file) {
    const std::string beside = std::filesystem::path(vehicle_file).parent_path().string();
    const std::string folder = beside.empty() ? "" : beside + "/";
    const bool is_beside = !path.empty() && path.starts_with(folder) && (!folder.empty() || !path.starts_with('/'));
    return is_beside ? "/etc/facet/" + path.substr(folder.size()) : path;
}

bool is_loopback(std::string_view host) { return host.starts_with("127.") || host == "::1" || host == "localhost"; }

bool leaves_computer_for_ros2(const Vehicle& vehicle) {
    const bool speaks = vehicle.cameras.ros2 || vehicle.imu_ros2 || vehicle.ros2_out;
    return speaks && std::ranges::any_of(vehicle.ros2.interfaces, [](const std::string& name) { return name != "lo"; });
}

}  // namespace

std::string service_drop_in(const Vehicle& vehicle) {
    std::string text = fmt::format(
        "# Made by facet check-config --drop-in of {}: rights of the devices and addresses that it names.\n[Service]\n"
        "DeviceAllow=\n",
        vehicle.source);
    for (const std::string& device : devices_of(vehicle)) {
        text += fmt::format("DeviceAllow={} rw\n", escaped(device));
    }
    if (vehicle.mavlink && vehicle.mavlink->channel.serial.empty() && !is_loopback(vehicle.mavlink->channel.udp_host)) {
        text += fmt::format("IPAddressAllow={}\n", escaped(vehicle.mavlink->channel.udp_host));
    }
    if (leaves_computer_for_ros2(vehicle)) {
        text +=
            "# Whoever speaks ROS 2 on the interfaces that the vehicle file names, and "
            "multicast.\nIPAddressAllow=any\n";
    }
    const std::string log = on_vehicle(vehicle.log.folder, vehicle.source);
    if (!log.empty() && !log.starts_with("/var/lib/facet/")) {
        text += fmt::format("ReadWritePaths=-{}\n", escaped(log));
    }
    if (vehicle.world) {
        const std::string folder = std::filesystem::path(vehicle.world->path).parent_path().string();
        if (!folder.empty() && folder != "/run/facet") {
            text += fmt::format("ReadWritePaths=-{}\n", escaped(folder));
        }
        if (!vehicle.world->group.empty()) {
            text += fmt::format(
                "# To give the planners' socket to their group.\nSupplementaryGroups={}\n"
                "SystemCallFilter=@chown\n",
                escaped(vehicle.world->group));
        }
    }
    if (vehicle.imu_iio) {
        text += "# The attributes of the inertial sensor, whose rights udev's rules give.\nProtectKernelTunables=no\n";
    }
    if (vehicle.pulses && !vehicle.pulses->pwm_chip.empty()) {
        const std::string chip = escaped(vehicle.pulses->pwm_chip);
        const int channel = vehicle.pulses->pwm_channel;
        const std::string pwm = fmt::format("{}/pwm{}", chip, channel);
        text += fmt::format(
            "# The files of the trigger's pulses, for the service's user alone.\nProtectKernelTunables=no\n"
            "ExecStartPre=+/bin/sh -c '[ -d {1} ] || echo {2} > {0}/export; "
            "chown facet {1}/period {1}/duty_cycle {1}/enable'\n",
            chip, pwm, channel);
    }
    return text;
}

}  // namespace facet
