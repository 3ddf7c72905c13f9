// SPDX-License-Identifier: BSD-2-Clause
// In the place of Cyclone DDS where that is not installed, or not wanted.
#include "drivers/ros2/ros2_node.h"

namespace facet {
namespace {

constexpr const char* kWithoutRos2 = "this program was built without Cyclone DDS, and so without ROS 2";

template <class Message>
class AbsentReader final : public Ros2Reader<Message> {
public:
    Status open(std::string& problem) override {
        problem = kWithoutRos2;
        return Status::kInvalidArgument;
    }
    void close() override {}
    Status take(Duration /*timeout*/, Message& /*message*/) override { return Status::kNotReady; }
    std::uint64_t lost() const override { return 0; }
};

class AbsentPublisher final : public Ros2Publisher {
public:
    Status open(std::string& problem) override {
        problem = kWithoutRos2;
        return Status::kInvalidArgument;
    }
    void close() override {}
    bool has_listeners(Ros2Topic /*topic*/) const override { return false; }
    Status publish(const Ros2Odometry& /*odometry*/) override { return Status::kIo; }
    Status publish(Timestamp /*stamp*/, const Ros2Diagnostic& /*diagnostic*/) override { return Status::kIo; }
    Status publish(Ros2Topic /*topic*/, Timestamp /*stamp*/, std::span<const Ros2Triangle> /*triangles*/) override {
        return Status::kIo;
    }
    Status publish(Timestamp /*stamp*/, std::span<const Eigen::Vector3f> /*landmarks*/) override { return Status::kIo; }
    Status publish(Timestamp /*stamp*/, std::span<const Ros2Pose> /*path*/) override { return Status::kIo; }
};

class AbsentNode final : public Ros2Node {
public:
    std::unique_ptr<Ros2Reader<Ros2Image>> image_reader(const std::string& /*topic*/) override {
        return std::make_unique<AbsentReader<Ros2Image>>();
    }
    std::unique_ptr<Ros2Reader<Ros2Inertial>> imu_reader(const std::string& /*topic*/) override {
        return std::make_unique<AbsentReader<Ros2Inertial>>();
    }
    std::unique_ptr<Ros2Reader<Ros2CameraModel>> camera_info_reader(const std::string& /*topic*/,
                                                                    bool /*rectified*/) override {
        return std::make_unique<AbsentReader<Ros2CameraModel>>();
    }
    std::unique_ptr<Ros2Publisher> publisher(const Ros2OutputNames& /*names*/) override {
        return std::make_unique<AbsentPublisher>();
    }
};

}  // namespace

bool has_ros2() { return false; }

std::unique_ptr<Ros2Node> make_ros2_node(const Ros2NodeOptions& /*options*/) { return std::make_unique<AbsentNode>(); }

}  // namespace facet
