// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <array>

#include <diagnostic_msgs.h>
#include <nav_msgs.h>
#include <sensor_msgs.h>
#include <tf2_msgs.h>
#include <visualization_msgs.h>
#include "drivers/ros2/cyclone_node.h"

namespace facet {
namespace {

/// What a topic is called, what it carries, and how.
struct TopicType {
    const char* name;
    const dds_topic_descriptor_t* type;
    int depth;
    bool has_prefix;
};

constexpr std::size_t kTopics = static_cast<std::size_t>(Ros2Topic::kCount);

const std::array<TopicType, kTopics>& topic_types() {
    static const std::array<TopicType, kTopics> kTypes{{
        {"/odometry", &nav_msgs_msg_dds__Odometry__desc, 10, true},
        {"/tf", &tf2_msgs_msg_dds__TFMessage__desc, 100, false},
        {"/diagnostics", &diagnostic_msgs_msg_dds__DiagnosticArray__desc, 10, false},
        {"/mesh", &visualization_msgs_msg_dds__Marker__desc, 1, true},
        {"/planes", &visualization_msgs_msg_dds__Marker__desc, 1, true},
        {"/landmarks", &sensor_msgs_msg_dds__PointCloud2__desc, 1, true},
        {"/path", &nav_msgs_msg_dds__Path__desc, 1, true},
        {"/grid", &nav_msgs_msg_dds__OccupancyGrid__desc, 1, true},
    }};
    return kTypes;
}

/// Messages have strings that may be written to; nobody does.
char* text_of(const char* text) { return const_cast<char*>(text); }

std_msgs_msg_dds__Header_ header_of(Timestamp stamp, const char* frame) {
    constexpr std::int64_t kSecond_ns = 1'000'000'000;
    return {{static_cast<std::int32_t>(stamp.ns / kSecond_ns), static_cast<std::uint32_t>(stamp.ns % kSecond_ns)},
            text_of(frame)};
}

geometry_msgs_msg_dds__Pose_ pose_of(const Eigen::Vector3d& p, const Eigen::Quaterniond& q) {
    return {{p.x(), p.y(), p.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

/// A sequence that borrows the elements of a vector.
template <class Sequence, class Element>
void borrow(Sequence& sequence, std::vector<Element>& elements) {
    sequence._buffer = elements.data();
    sequence._length = sequence._maximum = static_cast<std::uint32_t>(elements.size());
}

class CyclonePublisher final : public Ros2Publisher {
public:
    CyclonePublisher(CycloneNode& node, const Ros2OutputNames& names) : node_(node), names_(names) {}
    ~CyclonePublisher() override { close(); }

    Status open(std::string& problem) override;
    void close() override {
        for (std::size_t i = 0; i < kTopics; ++i) {
            writers_[i].reset();
            topics_[i].reset();
        }
    }
    bool has_listeners(Ros2Topic topic) const override {
        dds_publication_matched_status_t matched{};
        const CycloneEntity& writer = writers_[static_cast<std::size_t>(topic)];
        return writer.is_set() && dds_get_publication_matched_status(writer.get(), &matched) == DDS_RETCODE_OK &&
               matched.current_count > 0;
    }
    Status publish(const Ros2Odometry& odometry) override;
    Status publish(Timestamp stamp, const Ros2Diagnostic& diagnostic) override;
    Status publish(Ros2Topic topic, Timestamp stamp, std::span<const Ros2Triangle> triangles) override;
    Status publish(Timestamp stamp, std::span<const Eigen::Vector3f> landmarks) override;
    Status publish(Timestamp stamp, std::span<const Ros2Pose> path) override;
    Status publish(Timestamp stamp, const Ros2Grid& grid) override;
    Status publish_map(Timestamp stamp, const Ros2Pose& odom_in_map) override;

private:
    bool is_wanted(Ros2Topic topic) const {
        return (topic != Ros2Topic::kTransform || names_.has_transform) &&
               (topic != Ros2Topic::kGrid || names_.has_grid);
    }
    Status transform(const std_msgs_msg_dds__Header_& header, char* child, const Ros2Pose& pose);
    Status write(Ros2Topic topic, const void* message) {
        const dds_return_t written = dds_write(writers_[static_cast<std::size_t>(topic)].get(), message);
        return written == DDS_RETCODE_OK ? Status::kOk : written == DDS_RETCODE_TIMEOUT ? Status::kFull : Status::kIo;
    }

    CycloneNode& node_;
    Ros2OutputNames names_;
    std::array<CycloneEntity, kTopics> topics_;
    std::array<CycloneEntity, kTopics> writers_;
    // Kept for their memory:
    std::vector<geometry_msgs_msg_dds__Point_> points_;
    std::vector<std_msgs_msg_dds__ColorRGBA_> colours_;
    std::vector<geometry_msgs_msg_dds__PoseStamped_> poses_;
};

Status CyclonePublisher::open(std::string& problem) {
    FACET_TRY(node_.open(problem));
    for (std::size_t i = 0; i < kTopics; ++i) {
        const TopicType& type = topic_types()[i];
        if (!is_wanted(static_cast<Ros2Topic>(i))) {
            continue;
        }
        const std::string name = (type.has_prefix ? names_.prefix : "") + type.name;
        if (!topics_[i].set(node_.make_topic(name, *type.type)) ||
            !writers_[i].set(node_.make_writer(topics_[i].get(), {true, type.depth}))) {
            close();
            problem = name + ": cannot be published: Cyclone DDS refuses";
            return Status::kIo;
        }
    }
    return Status::kOk;
}

Status CyclonePublisher::publish(const Ros2Odometry& odometry) {
    const std_msgs_msg_dds__Header_ header = header_of(odometry.stamp, names_.odom_frame.c_str());
    char* const child = text_of(names_.base_frame.c_str());
    const Eigen::Vector3d& p = odometry.p;
    const Eigen::Quaterniond& q = odometry.q;
    nav_msgs_msg_dds__Odometry_ message{};
    message.header_ = header;
    message.child_frame_id_ = child;
    message.pose_.pose_ = pose_of(p, q);
    std::copy(odometry.pose_covariance.begin(), odometry.pose_covariance.end(), message.pose_.covariance_);
    message.twist_.twist_ = {{odometry.v_B.x(), odometry.v_B.y(), odometry.v_B.z()},
                             {odometry.w_B.x(), odometry.w_B.y(), odometry.w_B.z()}};
    std::copy(odometry.twist_covariance.begin(), odometry.twist_covariance.end(), message.twist_.covariance_);
    const Status written = write(Ros2Topic::kOdometry, &message);
    if (!names_.has_transform) {
        return written;
    }
    const Status transformed = transform(header, child, {p, q});
    return ok(written) ? transformed : written;
}

Status CyclonePublisher::transform(const std_msgs_msg_dds__Header_& header, char* child, const Ros2Pose& pose) {
    const Eigen::Vector3d& p = pose.p;
    const Eigen::Quaterniond& q = pose.q;
    geometry_msgs_msg_dds__TransformStamped_ transform{
        header, child, {{p.x(), p.y(), p.z()}, {q.x(), q.y(), q.z(), q.w()}}};
    tf2_msgs_msg_dds__TFMessage_ transforms{};
    transforms.transforms_ = {1, 1, &transform, false};
    return write(Ros2Topic::kTransform, &transforms);
}

Status CyclonePublisher::publish_map(Timestamp stamp, const Ros2Pose& odom_in_map) {
    return names_.has_transform
               ? transform(header_of(stamp, names_.map_frame.c_str()), text_of(names_.odom_frame.c_str()), odom_in_map)
               : Status::kOk;
}

Status CyclonePublisher::publish(Timestamp stamp, const Ros2Diagnostic& diagnostic) {
    std::vector<diagnostic_msgs_msg_dds__KeyValue_> values;
    for (const auto& [key, value] : diagnostic.values) {
        values.push_back({text_of(key.c_str()), text_of(value.c_str())});
    }
    diagnostic_msgs_msg_dds__DiagnosticStatus_ status{};
    status.level_ = static_cast<std::uint8_t>(diagnostic.level);
    status.name_ = text_of(diagnostic.name.c_str());
    status.message_ = text_of(diagnostic.message.c_str());
    status.hardware_id_ = text_of("facet");
    borrow(status.values_, values);
    diagnostic_msgs_msg_dds__DiagnosticArray_ message{};
    message.header_ = header_of(stamp, "");
    message.status_ = {1, 1, &status, false};
    return write(Ros2Topic::kDiagnostics, &message);
}

/// A marker of no triangles is refused by RViz: the old one is removed instead.
Status CyclonePublisher::publish(Ros2Topic topic, Timestamp stamp, std::span<const Ros2Triangle> triangles) {
    constexpr std::int32_t kTriangleList = 11;
    constexpr std::int32_t kAdd = 0;
    constexpr std::int32_t kDelete = 2;
    points_.clear();
    colours_.clear();
    for (const Ros2Triangle& triangle : triangles) {
        const Ros2Colour& c = triangle.colour;
        for (const Eigen::Vector3f& p : triangle.p) {
            points_.push_back({p.x(), p.y(), p.z()});
            colours_.push_back({c[0], c[1], c[2], c[3]});
        }
    }
    visualization_msgs_msg_dds__Marker_ marker{};
    marker.header_ = header_of(stamp, names_.odom_frame.c_str());
    marker.ns_ = text_of(topic == Ros2Topic::kMesh ? "mesh" : "planes");
    marker.type_ = kTriangleList;
    marker.action_ = triangles.empty() ? kDelete : kAdd;
    marker.pose_.orientation_.w_ = 1.0;
    marker.scale_ = {1.0, 1.0, 1.0};
    marker.color_ = {1.0F, 1.0F, 1.0F, 1.0F};
    borrow(marker.points_, points_);
    borrow(marker.colors_, colours_);
    for (char** text : {&marker.texture_resource_, &marker.texture_.header_.frame_id_, &marker.texture_.format_,
                        &marker.text_, &marker.mesh_resource_, &marker.mesh_file_.filename_}) {
        *text = text_of("");
    }
    return write(topic, &marker);
}

Status CyclonePublisher::publish(Timestamp stamp, std::span<const Eigen::Vector3f> landmarks) {
    constexpr std::uint8_t kFloat32 = 7;
    static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
    std::array<sensor_msgs_msg_dds__PointField_, 3> fields{{{text_of("x"), 0, kFloat32, 1},
                                                            {text_of("y"), sizeof(float), kFloat32, 1},
                                                            {text_of("z"), 2 * sizeof(float), kFloat32, 1}}};
    sensor_msgs_msg_dds__PointCloud2_ cloud{};
    cloud.header_ = header_of(stamp, names_.odom_frame.c_str());
    cloud.height_ = 1;
    cloud.width_ = static_cast<std::uint32_t>(landmarks.size());
    cloud.fields_ = {fields.size(), fields.size(), fields.data(), false};
    cloud.point_step_ = sizeof(Eigen::Vector3f);
    cloud.row_step_ = cloud.width_ * cloud.point_step_;
    auto* const bytes = reinterpret_cast<std::uint8_t*>(const_cast<Eigen::Vector3f*>(landmarks.data()));
    cloud.data_ = {cloud.row_step_, cloud.row_step_, bytes, false};
    cloud.is_dense_ = true;
    return write(Ros2Topic::kLandmarks, &cloud);
}

Status CyclonePublisher::publish(Timestamp stamp, std::span<const Ros2Pose> path) {
    const std_msgs_msg_dds__Header_ header = header_of(stamp, names_.odom_frame.c_str());
    poses_.clear();
    for (const Ros2Pose& pose : path) {
        poses_.push_back({header, pose_of(pose.p, pose.q)});
    }
    nav_msgs_msg_dds__Path_ message{};
    message.header_ = header;
    borrow(message.poses_, poses_);
    return write(Ros2Topic::kPath, &message);
}

Status CyclonePublisher::publish(Timestamp stamp, const Ros2Grid& grid) {
    nav_msgs_msg_dds__OccupancyGrid_ message{};
    message.header_ = header_of(stamp, names_.odom_frame.c_str());
    message.info_.map_load_time_ = message.header_.stamp_;
    message.info_.resolution_ = grid.cell_m;
    message.info_.width_ = grid.width;
    message.info_.height_ = grid.height;
    message.info_.origin_ = pose_of(grid.corner, Eigen::Quaterniond::Identity());
    const auto cells = static_cast<std::uint32_t>(grid.cells.size());
    auto* const bytes = reinterpret_cast<std::uint8_t*>(const_cast<std::int8_t*>(grid.cells.data()));
    message.data_ = {cells, cells, bytes, false};
    return write(Ros2Topic::kGrid, &message);
}

}  // namespace

std::unique_ptr<Ros2Publisher> CycloneNode::publisher(const Ros2OutputNames& names) {
    return std::make_unique<CyclonePublisher>(*this, names);
}

}  // namespace facet
