// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_file.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <utility>

#include "app/calibration/calibration_fields.h"
#include "app/config/calibrated_config.h"
#include "app/config/config_file.h"
#include "app/config/config_table.h"
#include "app/config/vehicle_can_out.h"
#include "app/config/vehicle_mavlink.h"
#include "app/config/vehicle_ros2.h"
#include "app/config/vehicle_sensors.h"
#include "app/support/input_error.h"
#include "app/support/yaml_section.h"
#include "platform/base/angle.h"

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

/// T_V_B of the frame V that is reported: four rows as in Kalibr's files, or {place_m: [x, y, z], rpy_deg: [r, p, y]},
/// where the IMU sits in V and R_V_B = Rz(y) Ry(p) Rx(r).
Se3 read_body(const YamlNode& node) {
    constexpr double kLongest_m = 100.0;
    Se3 T;
    if (node.raw().IsSequence()) {
        T = read_transform(node);
    } else {
        YamlSection section(node);
        if (const auto place = section.find("place_m")) {
            const std::vector<double> p = place->numbers(3);
            T.p = {p[0], p[1], p[2]};
        }
        if (const auto turn = section.find("rpy_deg")) {
            const std::vector<double> rpy_deg = turn->numbers(3);
            const auto about = [&](std::size_t i, const Eigen::Vector3d& axis) {
                return Eigen::AngleAxisd(kRadPerDeg * rpy_deg[i], axis);
            };
            T.q = about(2, Eigen::Vector3d::UnitZ()) * about(1, Eigen::Vector3d::UnitY()) *
                  about(0, Eigen::Vector3d::UnitX());
        }
        section.finish();
    }
    if (!(T.p.norm() <= kLongest_m) || !T.q.coeffs().allFinite()) {
        node.fail("must be finite, and the place within 100 m");
    }
    return T;
}

VehicleWorld read_world(const YamlNode& node) {
    VehicleWorld world;
    YamlSection section(node);
    world.path = section.at("path").text();
    section.read("group", world.group);
    std::string mode = "0660";
    section.read("mode", mode);
    const auto [end, error] = std::from_chars(mode.data(), mode.data() + mode.size(), world.mode, 8);
    if (error != std::errc{} || end != mode.data() + mode.size() || world.mode > 0777) {
        node.fail("mode must be octal digits up to 0777, such as 0660");
    }
    section.finish();
    return world;
}

void read_sinks(const YamlNode& node, Vehicle& vehicle) {
    YamlSection section(node);
    section.read("rate_hz", vehicle.odometry.rate_hz, 0.0, 8000.0);
    section.read("smoothing_s", vehicle.odometry.smoothing_s, 0.0, 1.0);
    if (const auto body = section.find("T_body_imu")) {
        vehicle.odometry.T_body_imu = read_body(*body);
    }
    if (const auto mavlink = section.find("mavlink")) {
        read_mavlink(*mavlink, vehicle);
    }
    if (const auto can = section.find("can")) {
        vehicle.can_out = read_can_out(*can);
        check_can_nodes(*can, vehicle);
    }
    if (const auto world = section.find("world")) {
        vehicle.world = read_world(*world);
    }
    if (const auto log = section.find("log")) {
        YamlSection fields(*log);
        vehicle.log.folder = beside(fields.at("folder"));
        vehicle.log.by_flight = true;
        fields.read("keep_mb", vehicle.log.keep_mb, 0, 100'000'000);
        fields.read("mesh_faces", vehicle.log.mesh_faces, 0, 10'000'000);
        fields.read("timed_frames", vehicle.log.timed_frames, 1, 10'000'000);
        fields.finish();
    }
    // Last: it ends here in programs without ROS 2, whose reference must have the other keys.
    if (const auto ros2 = section.find("ros2")) {
        vehicle.ros2_out = read_ros2_out(*ros2);
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

/// Cameras that nobody triggers are set to their rate.
void set_rates(Vehicle& vehicle) {
    if (!vehicle.trigger && !vehicle.pulses) {
        vehicle.cameras.left.capture.rate_hz = vehicle.cameras.right.capture.rate_hz = vehicle.cameras.rate_hz;
    }
}

/// A device without data for ten of its periods is opened anew.
void set_silences(Vehicle& vehicle) {
    constexpr double kPeriods = 10.0;
    constexpr double kLeastForImu_s = 0.1;  // more than a reader may be kept from running
    const Duration frames = Duration::from_seconds(kPeriods / vehicle.cameras.rate_hz);
    const Duration samples =
        Duration::from_seconds(std::max(kLeastForImu_s, kPeriods / vehicle.calibration.noise.rate_hz));
    vehicle.cameras.left.silence = vehicle.cameras.right.silence = frames;
    if (vehicle.cameras.ros2) {
        vehicle.cameras.ros2->left.silence = vehicle.cameras.ros2->right.silence = frames;
    }
    if (vehicle.trigger) {
        vehicle.trigger->input.silence = frames;
    }
    if (vehicle.imu_spi) {
        vehicle.imu_spi->source.silence = samples;
    }
    if (vehicle.imu_can) {
        vehicle.imu_can->source.silence = samples;
    }
    if (vehicle.imu_iio) {
        vehicle.imu_iio->silence = samples;
    }
    if (vehicle.imu_serial) {
        vehicle.imu_serial->silence = samples;
    }
    constexpr double kLeastForLink_s = 0.25;  // other programs send when they have nothing better to do
    if (vehicle.imu_ros2) {
        vehicle.imu_ros2->silence = std::max(samples, Duration::from_seconds(kLeastForLink_s));
    }
    if (vehicle.imu_mavlink) {
        vehicle.imu_mavlink->silence =
            Duration::from_seconds(std::max(kLeastForLink_s, kPeriods / vehicle.imu_mavlink->rate_hz));
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

std::vector<std::string> check_vehicle(const std::string& path, Vehicle& vehicle) {
    return check_vehicle(load_yaml(path), nullptr, vehicle);
}

std::vector<std::string> check_vehicle(const YamlNode& file, const Calibration* known, Vehicle& vehicle) {
    Vehicle begun;  // not `vehicle = {}`, in which GCC 12 sees uninitialized strings
    begun.source = file.file();
    vehicle = std::move(begun);
    YamlSection root(file);
    std::vector<std::string> errors;
    const auto attempt = [&errors](auto read) {
        try {
            read();
            return true;
        } catch (const InputError& e) {
            errors.emplace_back(e.what());
            return false;
        }
    };
    const auto attempt_if_there = [&](const char* key, auto read) {
        if (const auto node = root.find(key)) {
            attempt([&] { read(*node); });
        }
    };
    const bool is_calibrated = attempt([&] {
        const YamlNode calibration = root.at("calibration");
        vehicle.calibration = known == nullptr ? read_calibration(calibration) : *known;
        take_calibration(vehicle.calibration, vehicle.config);
    });
    vehicle.config.regularity.mode = RegularityMode::kSpr;
    attempt_if_there("estimator", [&](const YamlNode& node) { read_estimator(node, vehicle); });
    if (is_calibrated) {
        attempt([&] { require_valid(vehicle); });
    }
    attempt([&] {
        const YamlNode cameras = root.at("cameras");
        if (is_calibrated) {  // which says how many there are and of what size
            vehicle.cameras = read_cameras(cameras, vehicle.calibration);
        }
    });
    attempt_if_there("trigger", [&](const YamlNode& node) { vehicle.trigger = read_trigger(node); });
    attempt_if_there("trigger_output",
                     [&](const YamlNode& node) { vehicle.pulses = read_pulses(node, vehicle.cameras.rate_hz); });
    attempt([&] { read_imu(root.at("imu"), vehicle); });
    attempt_if_there("ros2", [&](const YamlNode& node) { vehicle.ros2 = read_ros2(node); });
    bool has_link = false;
    attempt_if_there("sinks", [&](const YamlNode& node) {
        has_link = node.has("mavlink");
        read_sinks(node, vehicle);
    });
    attempt([&] {
        if (vehicle.imu_mavlink && !has_link) {
            throw InputError(vehicle.source +
                             ": imu.mavlink needs sinks.mavlink, which says where the flight controller is");
        }
    });
    attempt_if_there("realtime", [&](const YamlNode& node) { vehicle.realtime = read_realtime(node); });
    attempt([&] { root.finish(); });
    set_rates(vehicle);
    set_silences(vehicle);
    return errors;
}

Vehicle load_vehicle(const std::string& path) {
    Vehicle vehicle;
    if (const std::vector<std::string> errors = check_vehicle(path, vehicle); !errors.empty()) {
        throw InputError(errors.front());
    }
    return vehicle;
}

}  // namespace facet
