// SPDX-License-Identifier: BSD-2-Clause
// A participant in a ROS 2 graph: what drivers read from topics and write to them through.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/ros2/ros2_messages.h"
#include "platform/base/status.h"

namespace facet {

struct Ros2NodeOptions {
    int domain = 0;                             ///< ROS_DOMAIN_ID of the others, 0 to 232
    std::vector<std::string> interfaces{"lo"};  ///< on which it is visible, and nowhere else
    std::vector<std::string> peers;             ///< addresses to ask where no multicast gets through
};

/// Messages of one topic. Thread-bound. Heap in open(), and where the middleware needs it.
template <class Message>
class Ros2Reader {
public:
    virtual ~Ros2Reader() = default;

    /// Opens the node, too, if it is not open.
    /// @return kIo or kInvalidArgument with the words
    virtual Status open(std::string& problem) = 0;
    virtual void close() = 0;
    /// The oldest message that waits. @return kNotReady if none has come in time or it is not open; kIo if the
    /// middleware fails
    virtual Status take(Duration timeout, Message& message) = 0;
    /// Messages that never arrived or found no room, since open(), as far as the middleware knows.
    virtual std::uint64_t lost() const = 0;
};

enum class Ros2Topic : std::uint8_t {
    kOdometry,
    kTransform,
    kDiagnostics,
    kMesh,
    kPlanes,
    kLandmarks,
    kPath,
    kGrid,
    kCount
};

struct Ros2OutputNames {
    std::string prefix = "/facet";  ///< of all topics but /tf and /diagnostics
    std::string map_frame = "map";
    std::string odom_frame = "odom";
    std::string base_frame = "base_link";
    bool has_transform = true;  ///< publishes /tf
    bool has_grid = false;      ///< publishes the grid, which takes time to keep
};

/// Topics that are written. Thread-bound, except for has_listeners(). All stamps are of CLOCK_REALTIME. Each function
/// @return kFull if the middleware has no room: dropped; kIo if it fails; kOk also if nobody listens.
class Ros2Publisher {
public:
    virtual ~Ros2Publisher() = default;

    virtual Status open(std::string& problem) = 0;
    virtual void close() = 0;
    virtual bool has_listeners(Ros2Topic topic) const = 0;
    /// Pose and motion, and the transform, which is the same pose again.
    virtual Status publish(const Ros2Odometry& odometry) = 0;
    virtual Status publish(Timestamp stamp, const Ros2Diagnostic& diagnostic) = 0;
    /// @param topic  kMesh or kPlanes
    virtual Status publish(Ros2Topic topic, Timestamp stamp, std::span<const Ros2Triangle> triangles) = 0;
    virtual Status publish(Timestamp stamp, std::span<const Eigen::Vector3f> landmarks) = 0;
    virtual Status publish(Timestamp stamp, std::span<const Ros2Pose> path) = 0;
    virtual Status publish(Timestamp stamp, const Ros2Grid& grid) = 0;
    /// The transform from the odometry's frame to the map's (REP-105); kOk without one if has_transform is false.
    virtual Status publish_map(Timestamp stamp, const Ros2Pose& odom_in_map) = 0;
};

/// Must outlive its readers and publishers. Thread-safe. Constructing it touches no network.
class Ros2Node {
public:
    virtual ~Ros2Node() = default;

    /// @param topic  as ROS 2 names it, such as /camera/infra1/image_rect_raw; one that ends in /compressed is of type
    ///               CompressedImage
    virtual std::unique_ptr<Ros2Reader<Ros2Image>> image_reader(const std::string& topic) = 0;
    virtual std::unique_ptr<Ros2Reader<Ros2Inertial>> imu_reader(const std::string& topic) = 0;
    /// @param rectified  the image is: the projection P counts, else K
    virtual std::unique_ptr<Ros2Reader<Ros2CameraModel>> camera_info_reader(const std::string& topic,
                                                                            bool rectified) = 0;
    virtual std::unique_ptr<Ros2Publisher> publisher(const Ros2OutputNames& names) = 0;
};

/// Whether there is a middleware, which is loaded by then: the module that the program was built with, if Cyclone DDS
/// was installed. Without, nothing can be opened.
bool has_ros2();
/// As long as nobody calls either function, the middleware is not even in memory.
std::unique_ptr<Ros2Node> make_ros2_node(const Ros2NodeOptions& options);

/// What is wrong with a topic's name by the rules of ROS 2; nullptr if nothing is. Reentrant. No heap.
const char* topic_fault(std::string_view topic);
/// The camera_info beside an image's topic, as image_transport has it. Reentrant. Heap.
std::string camera_info_topic(const std::string& image_topic);

}  // namespace facet
