// SPDX-License-Identifier: BSD-2-Clause
// The messages of ROS that a log is made of.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "app/lab/convert/bag.h"

namespace facet {

/// What a topic's messages can be in a log.
enum class RosKind : std::uint8_t { kImage, kCompressedImage, kImu, kPose, kCameraInfo, kTransforms };

/// By type: sensor_msgs Image, CompressedImage, Imu and CameraInfo; px4_msgs SensorCombined, which is an Imu;
/// geometry_msgs PoseStamped, PoseWithCovarianceStamped and TransformStamped, nav_msgs Odometry, and px4_msgs
/// VehicleOdometry, all of which are poses; tf2_msgs TFMessage. Empty for all others.
std::optional<RosKind> kind_of(std::string_view type);

/// The stamp of a message's header; not positive if nobody has set it.
struct RosImage {
    std::int64_t stamp_ns = 0;
    std::string_view frame;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t step = 0;      ///< bytes a row
    bool is_big_endian = false;  ///< of samples with 16 bits
    std::string_view encoding;   ///< mono8, bayer_rggb8, ...; of a compressed image its format
    std::span<const std::uint8_t> data;
};
struct RosImu {
    std::int64_t stamp_ns = 0;
    std::string_view frame;
    std::array<double, 6> values{};  ///< angular rate x y z (rad/s), specific force x y z (m/s^2)
};
struct RosPose {
    std::int64_t stamp_ns = 0;
    std::array<double, 7> values{};  ///< position x y z (m), quaternion w x y z
};

/// A camera's lens. K and P are row by row.
struct RosCameraInfo {
    std::string_view frame;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::string_view distortion_model;
    std::vector<double> d;
    std::array<double, 9> k{};
    std::array<double, 12> p{};
};
/// A frame in its parent: translation x y z (m), quaternion w x y z.
struct RosTransform {
    std::string_view parent;
    std::string_view child;
    std::array<double, 7> values{};
};

// Views into the message. @return false if it is cut off, or in a form that is not known. Reentrant. Heap: lists only.
bool read_message(const BagMessage& message, RosImage& image);  ///< kImage and kCompressedImage
bool read_message(const BagMessage& message, RosImu& imu);
bool read_message(const BagMessage& message, RosPose& pose);  ///< PX4's with z upwards: turned about x by half a turn
bool read_message(const BagMessage& message, RosCameraInfo& info);
bool read_message(const BagMessage& message, std::vector<RosTransform>& transforms);

}  // namespace facet
