// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <utility>

#include <sensor_msgs.h>
#include "drivers/ros2/cyclone_node.h"

namespace facet {
namespace {

/// ROS 2's QoS of sensor data. A driver's thread may be kept from running for a quarter of a second: at 400 Hz a
/// hundred inertial samples.
constexpr CycloneQos kImages{false, 5};
constexpr CycloneQos kSamples{false, 100};

std::string_view view_of(const char* text) { return text == nullptr ? std::string_view() : std::string_view(text); }

template <class Message>
Timestamp stamp_of(const Message& message) {
    return from_ros_time(message.header_.stamp_.sec_, message.header_.stamp_.nanosec_);
}

template <class Sequence>
std::span<const std::uint8_t> bytes_of(const Sequence& sequence) {
    return {sequence._buffer, sequence._length};
}

Eigen::Vector3d to_vector(const geometry_msgs_msg_dds__Vector3_& v) { return {v.x_, v.y_, v.z_}; }

void convert_image(const sensor_msgs_msg_dds__Image_& from, Ros2Image& to) {
    to = {stamp_of(from), view_of(from.encoding_), from.width_, from.height_,
          from.step_,     from.is_bigendian_ != 0, false,       bytes_of(from.data_)};
}

void convert_compressed(const sensor_msgs_msg_dds__CompressedImage_& from, Ros2Image& to) {
    to = {stamp_of(from), view_of(from.format_), 0, 0, 0, false, true, bytes_of(from.data_)};
}

void convert_imu(const sensor_msgs_msg_dds__Imu_& from, Ros2Inertial& to) {
    to = {stamp_of(from), to_vector(from.angular_velocity_), to_vector(from.linear_acceleration_),
          from.angular_velocity_covariance_[0] != -1.0, from.linear_acceleration_covariance_[0] != -1.0};
}

/// Of a rectified image the projection counts, of others K.
void convert_info(const sensor_msgs_msg_dds__CameraInfo_& from, bool is_rectified, Ros2CameraModel& to) {
    const bool has_projection = is_rectified && from.p_[0] > 0.0;
    to.width = from.width_;
    to.height = from.height_;
    to.fx = has_projection ? from.p_[0] : from.k_[0];
    to.fy = has_projection ? from.p_[5] : from.k_[4];
    to.cx = has_projection ? from.p_[2] : from.k_[2];
    to.cy = has_projection ? from.p_[6] : from.k_[5];
}

/// @tparam Dds  the message as idlc has it
template <class Dds, class Message>
class CycloneReader final : public Ros2Reader<Message> {
public:
    using Convert = void (*)(const Dds&, Message&);

    CycloneReader(CycloneNode& node, std::string topic, const dds_topic_descriptor_t& type, const CycloneQos& qos,
                  Convert convert)
        : node_(node), name_(std::move(topic)), type_(type), qos_(qos), convert_(convert) {}
    ~CycloneReader() override { close(); }

    Status open(std::string& problem) override {
        if (reader_.is_set()) {
            return Status::kOk;
        }
        FACET_TRY(node_.open(problem));
        const bool is_open =
            topic_.set(node_.make_topic(name_, type_)) && reader_.set(node_.make_reader(topic_.get(), qos_)) &&
            waitset_.set(dds_create_waitset(node_.participant())) &&
            dds_waitset_attach(waitset_.get(), dds_create_readcondition(reader_.get(), DDS_ANY_STATE), 0) >= 0;
        if (!is_open) {
            close();
            problem = name_ + ": cannot be subscribed to: Cyclone DDS refuses";
            return Status::kIo;
        }
        return Status::kOk;
    }

    void close() override {
        give_back();
        waitset_.reset();
        reader_.reset();
        topic_.reset();
        lost_ = 0;
    }

    Status take(Duration timeout, Message& message) override {
        if (!reader_.is_set()) {
            return Status::kNotReady;
        }
        Status status = take_now(message);
        if (status == Status::kNotReady && timeout.ns > 0) {
            if (dds_waitset_wait(waitset_.get(), nullptr, 0, timeout.ns) < 0) {
                return Status::kIo;
            }
            status = take_now(message);
        }
        dds_sample_lost_status_t lost;
        if (dds_get_sample_lost_status(reader_.get(), &lost) == DDS_RETCODE_OK) {
            lost_ = lost.total_count;
        }
        return status;
    }

    std::uint64_t lost() const override { return lost_; }

private:
    /// Passes over what says that a writer has gone.
    Status take_now(Message& message) {
        for (;;) {
            give_back();
            dds_sample_info_t info;
            const dds_return_t count = dds_take(reader_.get(), &sample_, &info, 1, 1);
            if (count <= 0) {
                sample_ = nullptr;
                return count == 0 ? Status::kNotReady : Status::kIo;
            }
            if (info.valid_data) {
                convert_(*static_cast<const Dds*>(sample_), message);
                return Status::kOk;
            }
        }
    }

    void give_back() {
        if (sample_ != nullptr) {
            (void)dds_return_loan(reader_.get(), &sample_, 1);
            sample_ = nullptr;
        }
    }

    CycloneNode& node_;
    std::string name_;
    const dds_topic_descriptor_t& type_;
    CycloneQos qos_;
    Convert convert_;
    CycloneEntity topic_;
    CycloneEntity reader_;
    CycloneEntity waitset_;
    void* sample_ = nullptr;  ///< lent by the middleware
    std::uint64_t lost_ = 0;
};

}  // namespace

std::unique_ptr<Ros2Reader<Ros2Image>> CycloneNode::image_reader(const std::string& topic) {
    if (topic.ends_with("/compressed")) {
        using Reader = CycloneReader<sensor_msgs_msg_dds__CompressedImage_, Ros2Image>;
        return std::make_unique<Reader>(*this, topic, sensor_msgs_msg_dds__CompressedImage__desc, kImages,
                                        convert_compressed);
    }
    using Reader = CycloneReader<sensor_msgs_msg_dds__Image_, Ros2Image>;
    return std::make_unique<Reader>(*this, topic, sensor_msgs_msg_dds__Image__desc, kImages, convert_image);
}

std::unique_ptr<Ros2Reader<Ros2Inertial>> CycloneNode::imu_reader(const std::string& topic) {
    using Reader = CycloneReader<sensor_msgs_msg_dds__Imu_, Ros2Inertial>;
    return std::make_unique<Reader>(*this, topic, sensor_msgs_msg_dds__Imu__desc, kSamples, convert_imu);
}

std::unique_ptr<Ros2Reader<Ros2CameraModel>> CycloneNode::camera_info_reader(const std::string& topic, bool rectified) {
    using Dds = sensor_msgs_msg_dds__CameraInfo_;
    using Reader = CycloneReader<Dds, Ros2CameraModel>;
    const Reader::Convert raw = [](const Dds& from, Ros2CameraModel& to) { convert_info(from, false, to); };
    const Reader::Convert projected = [](const Dds& from, Ros2CameraModel& to) { convert_info(from, true, to); };
    return std::make_unique<Reader>(*this, topic, sensor_msgs_msg_dds__CameraInfo__desc, kImages,
                                    rectified ? projected : raw);
}

}  // namespace facet
