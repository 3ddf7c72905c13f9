// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_mavlink.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "app/config/vehicle_sensors.h"
#include "app/support/yaml_section.h"

namespace facet {
namespace {

void read_byte(YamlSection& section, const char* key, std::uint8_t& value, int low, int high) {
    int number = value;
    section.read(key, number, low, high);
    value = static_cast<std::uint8_t>(number);
}

void read_port(YamlSection& section, const char* key, std::uint16_t& value, int low) {
    int number = value;
    section.read(key, number, low, 65535);
    value = static_cast<std::uint16_t>(number);
}

/// 64 hexadecimal digits.
MavlinkKey read_key(const YamlNode& path) {
    const std::string name = beside(path);
    std::ifstream file(name);
    std::string text;
    if (!(file >> text)) {
        path.fail(name + ": cannot be read");
    }
    MavlinkKey key{};
    bool good = text.size() == 2 * key.size();
    for (std::size_t i = 0; good && i < key.size(); ++i) {
        const char* const digits = text.data() + 2 * i;
        good = std::from_chars(digits, digits + 2, key[i], 16).ptr == digits + 2;
    }
    if (!good) {
        path.fail(name + ": must hold 64 hexadecimal digits");
    }
    return key;
}

MavlinkSigningOptions read_signing(const YamlNode& node) {
    MavlinkSigningOptions signing;
    YamlSection section(node);
    const YamlNode key = section.at("key_file");
    read_byte(section, "link", signing.link, 0, 255);
    section.read("accept_unsigned", signing.accept_unsigned);
    section.finish();
    signing.key = read_key(key);
    return signing;
}

ObstacleOptions read_obstacles(const YamlNode& node) {
    ObstacleOptions obstacles;
    YamlSection section(node);
    section.read("max_range_m", obstacles.max_range_m, 1.0, 100.0);
    section.read("below_m", obstacles.below_m, 0.0, 10.0);
    section.read("above_m", obstacles.above_m, 0.0, 10.0);
    section.read("rate_hz", obstacles.rate_hz, 0.1, 30.0);
    section.finish();
    return obstacles;
}

MavlinkRangeOptions read_range(const YamlNode& node) {
    constexpr double kFarthest_m = 10.0;
    MavlinkRangeOptions range;
    YamlSection section(node);
    read_byte(section, "id", range.id, 0, 255);
    double latency_s = 0.0;
    section.read("latency_s", latency_s, 0.0, 1.0);
    range.latency = Duration::from_seconds(latency_s);
    if (const auto place = section.find("place_m")) {
        const std::vector<double> p = place->numbers(3);
        range.place_B = {p[0], p[1], p[2]};
        if (!(range.place_B.norm() <= kFarthest_m)) {
            place->fail("must be finite, and within 10 m");
        }
    }
    section.finish();
    return range;
}

GlobalOrigin read_origin(const YamlNode& node) {
    GlobalOrigin origin;
    YamlSection section(node);
    static_cast<void>(section.at("latitude_deg"));  // without default
    static_cast<void>(section.at("longitude_deg"));
    section.read("latitude_deg", origin.latitude_deg, -90.0, 90.0);
    section.read("longitude_deg", origin.longitude_deg, -180.0, 180.0);
    section.read("altitude_m", origin.altitude_m, -500.0, 9000.0);
    section.finish();
    return origin;
}

void read_channel(YamlSection& section, MavlinkChannelOptions& channel) {
    section.read("udp_host", channel.udp_host);
    read_port(section, "udp_port", channel.udp_port, 1);
    read_port(section, "udp_local_port", channel.udp_local_port, 0);
    section.read("serial", channel.serial);
    section.read("baud", channel.baud, 1200, 4'000'000);
    const YamlNode& node = section.node();
    if (!channel.serial.empty() && (node.has("udp_host") || node.has("udp_port") || node.has("udp_local_port"))) {
        node.fail("has both 'serial' and a 'udp_' field; choose one");
    }
}

}  // namespace

void read_mavlink(const YamlNode& node, Vehicle& vehicle) {
    YamlSection section(node);
    MavlinkOptions options;
    read_channel(section, options.channel);
    read_byte(section, "system", options.address.system, 1, 255);
    read_byte(section, "component", options.address.component, 1, 255);
    read_byte(section, "autopilot_component", options.autopilot_component, 1, 255);
    read_byte(section, "commands_from", options.commands_from, 0, 255);
    constexpr std::array<std::string_view, 2> kMessages{"odometry", "vision_position_estimate"};
    options.message = static_cast<PoseMessage>(section.choice("message", kMessages, 0));
    constexpr std::array<std::string_view, 2> kFrames{"odom", "map"};
    options.in_map = section.choice("frame", kFrames, 0) == 1;
    constexpr std::array<std::string_view, 2> kTimes{"autopilot", "own"};
    options.time = static_cast<MavlinkTime>(section.choice("time", kTimes, 0));
    section.read("send_lost", options.send_lost);
    if (const auto signing = section.find("signing")) {
        options.signing = read_signing(*signing);
    }
    if (const auto obstacles = section.find("obstacles")) {
        vehicle.obstacles = read_obstacles(*obstacles);
    }
    if (const auto range = section.find("range_finder")) {
        options.range = read_range(*range);
        const Se3 T_imu_body = vehicle.odometry.T_body_imu.inverse();  // known: it is read before
        options.range->place_B = T_imu_body * options.range->place_B;
        options.range->down_B = T_imu_body.q * options.range->down_B;
        vehicle.config.range.enabled = true;
    }
    if (const auto origin = section.find("origin")) {
        options.origin = read_origin(*origin);
    }
    section.finish();
    vehicle.mavlink = options;
}

ImuMavlinkOptions read_imu_mavlink(const YamlNode& node, double rate_hz) {
    constexpr double kLeastRate_hz = 20.0;
    constexpr double kMostRate_hz = 1000.0;
    ImuMavlinkOptions imu;
    YamlSection section(node);
    constexpr std::array<std::string_view, 5> kMessages{"highres_imu", "raw_imu", "scaled_imu", "scaled_imu2",
                                                        "scaled_imu3"};
    imu.message = static_cast<MavlinkImuMessage>(section.choice("message", kMessages, 0));
    imu.rate_hz = std::clamp(rate_hz, kLeastRate_hz, kMostRate_hz);
    section.read("rate_hz", imu.rate_hz, kLeastRate_hz, kMostRate_hz);
    read_byte(section, "id", imu.id, 0, 255);
    section.read("gyro_filter_hz", imu.gyro_filter_hz, 0.0, 1000.0);
    section.read("accel_filter_hz", imu.accel_filter_hz, 0.0, 1000.0);
    section.finish();
    for (const double cutoff_hz : {imu.gyro_filter_hz, imu.accel_filter_hz}) {
        if (cutoff_hz != 0.0 && cutoff_hz < 1.0) {
            node.fail("a filter's cut-off must be 1 Hz at least, or 0: none");
        }
    }
    return imu;
}

}  // namespace facet
