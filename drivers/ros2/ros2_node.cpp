// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/ros2_node.h"

#include <dlfcn.h>
#include <unistd.h>

#include <array>
#include <utility>

#include "drivers/ros2/ros2_module.h"

namespace facet {
namespace {

/// The folder of the program that runs, with its slash.
std::string program_folder() {
    std::array<char, 4096> path{};
    const ssize_t length = ::readlink("/proc/self/exe", path.data(), path.size());
    const std::string program(path.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
    return program.substr(0, program.rfind('/') + 1);
}

/// What the middleware's module exports, loaded for good at the first call; nullptr with the words if there is none.
Ros2ModuleMake load_module(std::string& problem) {
    const std::string folder = program_folder();
    for (const std::string& place : {folder, folder + "../lib/facet/"}) {
        const std::string file = place + kRos2ModuleFile;
        if (::access(file.c_str(), R_OK) != 0) {
            continue;
        }
        if (void* const module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
            if (void* const make = ::dlsym(module, kRos2ModuleMake)) {
                return reinterpret_cast<Ros2ModuleMake>(make);
            }
        }
        const char* const words = ::dlerror();
        problem = file + " cannot be loaded: " + (words == nullptr ? "" : words);
        return nullptr;
    }
    problem = "this program was built without Cyclone DDS, and so without ROS 2";
    return nullptr;
}

template <class Message>
class AbsentReader final : public Ros2Reader<Message> {
public:
    explicit AbsentReader(std::string problem) : problem_(std::move(problem)) {}
    Status open(std::string& problem) override {
        problem = problem_;
        return Status::kInvalidArgument;
    }
    void close() override {}
    Status take(Duration /*timeout*/, Message& /*message*/) override { return Status::kNotReady; }
    std::uint64_t lost() const override { return 0; }

private:
    std::string problem_;
};

class AbsentPublisher final : public Ros2Publisher {
public:
    explicit AbsentPublisher(std::string problem) : problem_(std::move(problem)) {}
    Status open(std::string& problem) override {
        problem = problem_;
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
    Status publish(Timestamp /*stamp*/, const Ros2Grid& /*grid*/) override { return Status::kIo; }
    Status publish_map(Timestamp /*stamp*/, const Ros2Pose& /*odom_in_map*/) override { return Status::kIo; }

private:
    std::string problem_;
};

/// In the place of a middleware that is not there.
class AbsentNode final : public Ros2Node {
public:
    explicit AbsentNode(std::string problem) : problem_(std::move(problem)) {}
    std::unique_ptr<Ros2Reader<Ros2Image>> image_reader(const std::string& /*topic*/) override {
        return std::make_unique<AbsentReader<Ros2Image>>(problem_);
    }
    std::unique_ptr<Ros2Reader<Ros2Inertial>> imu_reader(const std::string& /*topic*/) override {
        return std::make_unique<AbsentReader<Ros2Inertial>>(problem_);
    }
    std::unique_ptr<Ros2Reader<Ros2CameraModel>> camera_info_reader(const std::string& /*topic*/,
                                                                    bool /*rectified*/) override {
        return std::make_unique<AbsentReader<Ros2CameraModel>>(problem_);
    }
    std::unique_ptr<Ros2Publisher> publisher(const Ros2OutputNames& /*names*/) override {
        return std::make_unique<AbsentPublisher>(problem_);
    }

private:
    std::string problem_;
};

}  // namespace

bool has_ros2() {
    std::string problem;
    return load_module(problem) != nullptr;
}

std::unique_ptr<Ros2Node> make_ros2_node(const Ros2NodeOptions& options) {
    std::string problem;
    if (const Ros2ModuleMake make = load_module(problem)) {
        return std::unique_ptr<Ros2Node>(make(options));
    }
    return std::make_unique<AbsentNode>(problem);
}

}  // namespace facet
