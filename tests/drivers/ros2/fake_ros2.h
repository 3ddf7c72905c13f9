// SPDX-License-Identifier: BSD-2-Clause
// A ROS 2 graph that a test fills and looks at, in the place of a middleware.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "drivers/ros2/ros2_node.h"

namespace facet::test {

/// An image with its own memory.
struct FakeImage {
    Ros2Image image;
    std::string encoding = "mono8";
    std::vector<std::uint8_t> data;
};

/// What all entities of the node share. A message that is offered while nobody has the topic open is gone.
struct FakeGraph {
    bool is_broken = false;
    std::uint64_t lost = 0;
    std::deque<FakeImage> images;
    std::deque<Ros2Inertial> samples;
    std::deque<Ros2CameraModel> models;

    // Of the publisher, on the output's thread:
    std::mutex mutex;
    bool has_listeners = true;
    bool is_full = false;
    std::vector<Ros2Odometry> odometry;
    std::vector<Ros2Diagnostic> diagnostics;
    std::vector<Ros2Pose> maps;
    std::vector<std::pair<Ros2Topic, std::size_t>> scenes;  ///< how many elements each had
};

template <class Message, class Stored>
class FakeReader final : public Ros2Reader<Message> {
public:
    FakeReader(FakeGraph& graph, std::deque<Stored>& queue) : graph_(graph), queue_(queue) {}

    Status open(std::string& problem) override {
        if (graph_.is_broken) {
            problem = "the graph is broken";
            return Status::kIo;
        }
        is_open_ = true;
        queue_.clear();
        return Status::kOk;
    }
    void close() override { is_open_ = false; }
    Status take(Duration /*timeout*/, Message& message) override {
        if (graph_.is_broken) {
            return Status::kIo;
        }
        if (!is_open_ || queue_.empty()) {
            return Status::kNotReady;
        }
        taken_ = std::move(queue_.front());
        queue_.pop_front();
        if constexpr (std::is_same_v<Stored, FakeImage>) {
            message = taken_.image;
            message.encoding = taken_.encoding;
            message.data = taken_.data;
        } else {
            message = taken_;
        }
        return Status::kOk;
    }
    std::uint64_t lost() const override { return is_open_ ? graph_.lost : 0; }

private:
    FakeGraph& graph_;
    std::deque<Stored>& queue_;
    Stored taken_;
    bool is_open_ = false;
};

class FakePublisher final : public Ros2Publisher {
public:
    explicit FakePublisher(FakeGraph& graph) : graph_(graph) {}

    Status open(std::string& problem) override {
        problem = graph_.is_broken ? "the graph is broken" : "";
        return graph_.is_broken ? Status::kIo : Status::kOk;
    }
    void close() override {}
    bool has_listeners(Ros2Topic /*topic*/) const override { return graph_.has_listeners; }
    Status publish(const Ros2Odometry& odometry) override {
        return keep([&] { graph_.odometry.push_back(odometry); });
    }
    Status publish(Timestamp /*stamp*/, const Ros2Diagnostic& diagnostic) override {
        return keep([&] { graph_.diagnostics.push_back(diagnostic); });
    }
    Status publish(Ros2Topic topic, Timestamp /*stamp*/, std::span<const Ros2Triangle> triangles) override {
        return keep([&] { graph_.scenes.emplace_back(topic, triangles.size()); });
    }
    Status publish(Timestamp /*stamp*/, std::span<const Eigen::Vector3f> landmarks) override {
        return keep([&] { graph_.scenes.emplace_back(Ros2Topic::kLandmarks, landmarks.size()); });
    }
    Status publish(Timestamp /*stamp*/, std::span<const Ros2Pose> path) override {
        return keep([&] { graph_.scenes.emplace_back(Ros2Topic::kPath, path.size()); });
    }
    Status publish(Timestamp /*stamp*/, const Ros2Grid& grid) override {
        return keep([&] { graph_.scenes.emplace_back(Ros2Topic::kGrid, grid.cells.size()); });
    }
    Status publish_map(Timestamp /*stamp*/, const Ros2Pose& odom_in_map) override {
        return keep([&] { graph_.maps.push_back(odom_in_map); });
    }

private:
    template <class Keep>
    Status keep(Keep keep) {
        const std::lock_guard lock(graph_.mutex);
        if (graph_.is_full) {
            return Status::kFull;
        }
        keep();
        return Status::kOk;
    }
    FakeGraph& graph_;
};

class FakeNode final : public Ros2Node {
public:
    std::unique_ptr<Ros2Reader<Ros2Image>> image_reader(const std::string& /*topic*/) override {
        return std::make_unique<FakeReader<Ros2Image, FakeImage>>(graph, graph.images);
    }
    std::unique_ptr<Ros2Reader<Ros2Inertial>> imu_reader(const std::string& /*topic*/) override {
        return std::make_unique<FakeReader<Ros2Inertial, Ros2Inertial>>(graph, graph.samples);
    }
    std::unique_ptr<Ros2Reader<Ros2CameraModel>> camera_info_reader(const std::string& topic, bool rectified) override {
        info_topic = topic;
        is_rectified = rectified;
        return std::make_unique<FakeReader<Ros2CameraModel, Ros2CameraModel>>(graph, graph.models);
    }
    std::unique_ptr<Ros2Publisher> publisher(const Ros2OutputNames& /*names*/) override {
        return std::make_unique<FakePublisher>(graph);
    }

    FakeGraph graph;
    std::string info_topic;
    bool is_rectified = false;
};

}  // namespace facet::test
