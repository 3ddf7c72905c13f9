// SPDX-License-Identifier: BSD-2-Clause
// What is taken from ROS 2 topics and given to them, as values that know nothing of DDS.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "platform/base/timestamp.h"

namespace facet {

/// An image as it arrived (sensor_msgs/Image or CompressedImage). Its views are valid until the reader that gave it
/// takes the next one, or is closed.
struct Ros2Image {
    Timestamp stamp;            ///< of the header: CLOCK_REALTIME
    std::string_view encoding;  ///< such as mono8; of a CompressedImage its format, such as "mono8; jpeg compressed"
    std::uint32_t width = 0;    ///< (px)
    std::uint32_t height = 0;   ///< (px)
    std::uint32_t step = 0;     ///< bytes from one row to the next
    bool is_bigendian = false;
    bool is_compressed = false;  ///< the data are a JPEG: width, height and step are in there
    std::span<const std::uint8_t> data;
};

/// sensor_msgs/Imu, as far as it is used.
struct Ros2Inertial {
    Timestamp stamp;                              ///< of the header: CLOCK_REALTIME
    Eigen::Vector3d w = Eigen::Vector3d::Zero();  ///< (rad/s)
    Eigen::Vector3d a = Eigen::Vector3d::Zero();  ///< specific force (m/s^2)
    bool has_rates = true, has_forces = true;     ///< the message does not say that it lacks them
};

/// sensor_msgs/CameraInfo, as far as it is used.
struct Ros2CameraModel {
    std::uint32_t width = 0;   ///< (px)
    std::uint32_t height = 0;  ///< (px)
    double fx = 0.0;           ///< (px)
    double fy = 0.0;
    double cx = 0.0;
    double cy = 0.0;
};

/// nav_msgs/Odometry and the transform of the same pose (REP 105). Covariances row by row: x, y, z, then turns about x,
/// y, z. The twist is in the child's frame.
struct Ros2Odometry {
    Timestamp stamp;  ///< CLOCK_REALTIME
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    std::array<double, 36> pose_covariance{};
    Eigen::Vector3d v_B = Eigen::Vector3d::Zero();
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();
    std::array<double, 36> twist_covariance{};
};

struct Ros2Pose {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
};

using Ros2Colour = std::array<float, 4>;  ///< red, green, blue, opacity: 0 to 1

struct Ros2Triangle {
    std::array<Eigen::Vector3f, 3> p;  ///< (m)
    Ros2Colour colour{};
};

/// nav_msgs/OccupancyGrid: cells row by row from a corner on, x first.
struct Ros2Grid {
    float cell_m = 0.0F;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    Eigen::Vector3d corner = Eigen::Vector3d::Zero();  ///< of the first cell (m)
    std::vector<std::int8_t> cells;                    ///< 0 free, 100 occupied, -1 unknown
};

/// What is shown beside the pose, in the odometry's frame; with each part whether it is new.
struct Ros2Scene {
    Timestamp stamp;  ///< of the keyframe, on the pipeline's clock
    bool has_mesh = false;
    std::vector<Ros2Triangle> mesh;
    std::vector<Ros2Triangle> planes;  ///< two for each
    bool has_landmarks = false;
    std::vector<Eigen::Vector3f> landmarks;
    bool has_path = false;
    std::vector<Ros2Pose> path;
    bool has_grid = false;
    Ros2Grid grid;
    bool has_map = false;
    Ros2Pose map;  ///< of the odometry's frame in that of the map of places
};

/// One status of diagnostic_msgs/DiagnosticArray.
struct Ros2Diagnostic {
    enum class Level : std::uint8_t { kOk, kWarn, kError, kStale };  // as the message counts them

    Level level = Level::kStale;
    std::string name;
    std::string message;
    std::vector<std::pair<std::string, std::string>> values;
};

}  // namespace facet
