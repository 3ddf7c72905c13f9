// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_ros2.h"

#include <fmt/core.h>

#include "app/config/read_duration.h"
#include "app/support/yaml_section.h"

namespace facet {
namespace {

constexpr int kMostDomain = 232;  // beyond, ports do not suffice

/// To be called once the section has been read.
void require_ros2(const YamlNode& node) {
    if (!has_ros2()) {
        node.fail("this program was built without ROS 2: install Cyclone DDS (scripts/setup --ros2) and rebuild it");
    }
}

std::string read_topic(const YamlNode& node) {
    std::string topic = node.text();
    if (const char* const fault = topic_fault(topic); fault != nullptr) {
        node.fail(fmt::format("'{}' {}", topic, fault));
    }
    return topic;
}

void read_texts(YamlSection& section, const char* key, std::vector<std::string>& texts) {
    if (const auto list = section.find(key)) {
        if (!list->raw().IsSequence()) {
            list->fail("must be a list");
        }
        texts.clear();
        for (const auto& item : list->raw()) {
            texts.push_back(item.IsScalar() ? item.Scalar() : "");
            if (texts.back().empty()) {
                list->fail("must be a list of names");
            }
        }
    }
}

void set_camera(CameraRos2Options& camera, const CameraIntrinsics& k) {
    camera.width = k.width;
    camera.height = k.height;
    camera.model = {static_cast<std::uint32_t>(k.width), static_cast<std::uint32_t>(k.height), k.fx, k.fy, k.cx, k.cy};
}

}  // namespace

Ros2NodeOptions read_ros2(const YamlNode& node) {
    Ros2NodeOptions options;
    YamlSection section(node);
    section.read("domain", options.domain, 0, kMostDomain);
    read_texts(section, "interfaces", options.interfaces);
    read_texts(section, "peers", options.peers);
    section.finish();
    if (options.interfaces.empty()) {
        node.fail("interfaces must name one, such as lo or eth0");
    }
    require_ros2(node);
    return options;
}

VehicleRos2Cameras read_ros2_cameras(const YamlNode& node, const Calibration& calibration) {
    VehicleRos2Cameras cameras;
    YamlSection section(node);
    const YamlNode left = section.at("left");
    const auto right = section.find("right");
    Duration latency;
    read_duration(section, "latency_s", latency, -1.0, 1.0);
    section.finish();
    if (right.has_value() != calibration.rig.has_right) {
        node.fail(right ? "the calibration has one camera: say 'left' only" : "must have 'right'");
    }
    set_camera(cameras.left, calibration.rig.left.intrinsics());
    set_camera(cameras.right, calibration.rig.right.intrinsics());
    cameras.left.latency = cameras.right.latency = latency;
    cameras.left.topic = read_topic(left);
    if (right) {
        cameras.right.topic = read_topic(*right);
        if (cameras.left.topic == cameras.right.topic) {
            right->fail("is the topic of the left camera");
        }
    }
    require_ros2(node);
    return cameras;
}

ImuRos2Options read_imu_ros2(const YamlNode& node) {
    ImuRos2Options imu;
    YamlSection section(node);
    imu.topic = read_topic(section.at("topic"));
    section.finish();
    require_ros2(node);
    return imu;
}

Ros2OutputNames read_ros2_out(const YamlNode& node) {
    Ros2OutputNames names;
    YamlSection section(node);
    if (const auto prefix = section.find("prefix")) {
        names.prefix = read_topic(*prefix);
    }
    section.read("odom_frame", names.odom_frame);
    section.read("base_frame", names.base_frame);
    section.read("tf", names.has_transform);
    section.read("grid", names.has_grid);
    section.finish();
    if (names.odom_frame.empty() || names.base_frame.empty() || names.odom_frame == names.base_frame) {
        node.fail("odom_frame and base_frame must be two names");
    }
    require_ros2(node);
    return names;
}

}  // namespace facet
