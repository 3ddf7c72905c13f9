// SPDX-License-Identifier: BSD-2-Clause
// The node by Cyclone DDS: domain and participant, and what its readers and publishers share.
#pragma once

#include <dds/dds.h>

#include <mutex>
#include <string>

#include "drivers/ros2/ros2_node.h"

namespace facet {

/// Deletes an entity at the end, and with it all that belongs to it. Thread-bound.
class CycloneEntity {
public:
    CycloneEntity() = default;
    ~CycloneEntity() { reset(); }
    CycloneEntity(const CycloneEntity&) = delete;
    CycloneEntity& operator=(const CycloneEntity&) = delete;

    /// @return whether this is an entity, and no error code
    bool set(dds_entity_t entity) {
        reset();
        entity_ = entity;
        return entity > 0;
    }
    void reset() {
        if (entity_ > 0) {
            (void)dds_delete(entity_);
        }
        entity_ = 0;
    }
    dds_entity_t get() const { return entity_; }
    bool is_set() const { return entity_ > 0; }

private:
    dds_entity_t entity_ = 0;
};

/// QoS as ROS 2 combines it, apart from the depth: volatile, keep last.
struct CycloneQos {
    bool is_reliable = false;
    int depth = 5;
};

class CycloneNode final : public Ros2Node {
public:
    explicit CycloneNode(const Ros2NodeOptions& options) : options_(options) {}

    std::unique_ptr<Ros2Reader<Ros2Image>> image_reader(const std::string& topic) override;
    std::unique_ptr<Ros2Reader<Ros2Inertial>> imu_reader(const std::string& topic) override;
    std::unique_ptr<Ros2Reader<Ros2CameraModel>> camera_info_reader(const std::string& topic, bool rectified) override;
    std::unique_ptr<Ros2Publisher> publisher(const Ros2OutputNames& names) override;

    // For readers and publishers, on any thread:
    /// Joins the domain, if that has not been done.
    Status open(std::string& problem);
    dds_entity_t participant() const { return participant_.get(); }
    /// @return the entity, or an error code
    dds_entity_t make_topic(const std::string& ros_topic, const dds_topic_descriptor_t& type) const;
    dds_entity_t make_reader(dds_entity_t topic, const CycloneQos& qos) const;
    dds_entity_t make_writer(dds_entity_t topic, const CycloneQos& qos) const;

private:
    Ros2NodeOptions options_;
    std::mutex mutex_;
    CycloneEntity domain_;
    CycloneEntity participant_;
};

/// In nanoseconds since 1970, from a message's two fields.
inline Timestamp from_ros_time(std::int32_t sec, std::uint32_t nanosec) {
    return {std::int64_t{sec} * 1'000'000'000 + nanosec};
}

}  // namespace facet
