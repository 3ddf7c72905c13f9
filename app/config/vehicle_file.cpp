// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_file.h"

#include <filesystem>

#include "app/config/calibrated_config.h"
#include "app/config/config_file.h"
#include "app/config/config_table.h"
#include "app/config/vehicle_sensors.h"
#include "app/support/input_error.h"
#include "app/support/yaml_section.h"

namespace facet {
namespace {

constexpr int kMaxCpu = 1023;
constexpr int kMaxFifo = 99;

Calibration read_calibration(const YamlNode& node) {
    YamlSection section(node);
    const auto euroc = section.find("euroc");
    const auto camchain = section.find("camchain");
    const auto imu = section.find("imu");
    section.finish();
    if (euroc && !camchain && !imu) {
        return load_euroc_calibration(beside(*euroc));
    }
    if (euroc || !camchain || !imu) {
        node.fail("must have either 'euroc' (a folder), or 'camchain' and 'imu' (Kalibr's files)");
    }
    return load_kalibr_calibration(beside(*camchain), beside(*imu));
}

void read_estimator(const YamlNode& node, Vehicle& vehicle) {
    YamlSection section(node);
    if (const auto config = section.find("config")) {
        load_config(beside(*config), vehicle.config);
    }
    RegularityMode& mode = vehicle.config.regularity.mode;
    mode = static_cast<RegularityMode>(section.choice("mode", kRegularityModeNames, static_cast<std::size_t>(mode)));
    section.finish();
}

SinkMavlinkOptions read_mavlink(const YamlNode& node) {
    YamlSection section(node);
    SinkMavlinkOptions options;
    section.read("udp_host", options.udp_host);
    int port = options.udp_port;
    section.read("udp_port", port, 1, 65535);
    options.udp_port = static_cast<std::uint16_t>(port);
    section.read("serial", options.serial);
    section.read("baud", options.baud, 1200, 4'000'000);
    int system = options.address.system;
    int component = options.address.component;
    section.read("system", system, 1, 255);
    section.read("component", component, 1, 255);
    options.address = {static_cast<std::uint8_t>(system), static_cast<std::uint8_t>(component)};
    section.finish();
    if (!options.serial.empty() && (node.has("udp_host") || node.has("udp_port"))) {
        node.fail("has both 'serial' and 'udp_host' or 'udp_port'; choose one");
    }
    return options;
}

void read_sinks(const YamlNode& node, Vehicle& vehicle) {
    YamlSection section(node);
    section.read("rate_hz", vehicle.odometry.rate_hz, 0.0, 8000.0);
    section.read("smoothing_s", vehicle.odometry.smoothing_s, 0.0, 1.0);
    if (const auto mavlink = section.find("mavlink")) {
        vehicle.mavlink = read_mavlink(*mavlink);
    }
    if (const auto log = section.find("log")) {
        YamlSection fields(*log);
        vehicle.log.folder = beside(fields.at("folder"));
        fields.read("mesh_faces", vehicle.log.mesh_faces, 0, 10'000'000);
        fields.read("timed_frames", vehicle.log.timed_frames, 1, 10'000'000);
        fields.finish();
    }
    section.finish();
}

ThreadOptions read_thread(YamlSection& threads, const char* name) {
    ThreadOptions options;
    if (const auto node = threads.find(name)) {
        YamlSection section(*node);
        section.read("cpu", options.cpu, -1, kMaxCpu);
        section.read("priority", options.priority, 0, kMaxFifo);
        section.finish();
    }
    return options;
}

VehicleRealtime read_realtime(const YamlNode& node) {
    VehicleRealtime realtime;
    YamlSection section(node);
    section.read("lock_memory", realtime.lock_memory);
    section.read("prefault_stack_kb", realtime.prefault_stack_kb, 0, 4096);
    if (const auto threads = section.find("threads")) {
        YamlSection list(*threads);
        realtime.estimator = read_thread(list, "estimator");
        realtime.cameras = read_thread(list, "cameras");
        realtime.imu = read_thread(list, "imu");
        realtime.trigger = read_thread(list, "trigger");
        realtime.output = read_thread(list, "output");
        list.finish();
    }
    section.finish();
    return realtime;
}

void require_valid(const Vehicle& vehicle) {
    if (const std::string fault = describe_fault(vehicle.config); !fault.empty()) {
        throw InputError(vehicle.source + ": " + fault);
    }
}

}  // namespace

std::string beside(const YamlNode& path) {
    const std::string text = path.text();
    if (text.empty()) {
        path.fail("must not be empty");
    }
    return (std::filesystem::path(path.file()).parent_path() / text).string();
}

Vehicle load_vehicle(const std::string& path) {
    Vehicle vehicle;
    vehicle.source = path;
    YamlSection root(load_yaml(path));
    vehicle.calibration = read_calibration(root.at("calibration"));
    take_calibration(vehicle.calibration, vehicle.config);
    vehicle.config.regularity.mode = RegularityMode::kSpr;
    if (const auto estimator = root.find("estimator")) {
        read_estimator(*estimator, vehicle);
    }
    require_valid(vehicle);
    vehicle.cameras = read_cameras(root.at("cameras"), vehicle.calibration);
    if (const auto trigger = root.find("trigger")) {
        vehicle.trigger = read_trigger(*trigger);
    }
    if (const auto pulses = root.find("trigger_output")) {
        vehicle.pulses = read_pulses(*pulses, vehicle.cameras.rate_hz);
    }
    read_imu(root.at("imu"), vehicle);
    if (const auto sinks = root.find("sinks")) {
        read_sinks(*sinks, vehicle);
    }
    if (const auto realtime = root.find("realtime")) {
        vehicle.realtime = read_realtime(*realtime);
    }
    root.finish();
    return vehicle;
}

}  // namespace facet
