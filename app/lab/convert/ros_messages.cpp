// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/ros_messages.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace facet {
namespace {

/// Takes fields from the front of a message. ROS 1 packs them, little-endian, and counts the characters of a text; CDR
/// aligns each to its size, counted from behind four bytes that say the order of bytes, and counts a final zero too.
class WireReader {
public:
    WireReader(WireFormat wire, std::span<const std::uint8_t> data) : is_cdr_(wire == WireFormat::kCdr), data_(data) {
        if (is_cdr_) {
            // Plain CDR is 0 (big-endian) and 1, version 2 of it 6 and 7: there eight bytes are aligned to four.
            const bool is_known = data.size() >= kCdrHead && data[0] == 0 && (data[1] < 2 || (data[1] | 1U) == 7);
            failed_ = !is_known;
            at_ = kCdrHead;
            is_swapped_ = is_known && data[1] % 2 == 0;
            most_aligned_ = is_known && data[1] > 1 ? 4 : 8;
        }
    }

    bool failed() const { return failed_; }

    template <class T>
    T take() {
        align(sizeof(T));
        const std::span<const std::uint8_t> bytes = take_bytes(sizeof(T));
        std::array<std::uint8_t, sizeof(T)> ordered{};
        std::copy(bytes.begin(), bytes.end(), ordered.begin());
        if (is_swapped_) {
            std::reverse(ordered.begin(), ordered.end());
        }
        T value;
        std::memcpy(&value, ordered.data(), sizeof(T));
        return value;
    }
    std::span<const std::uint8_t> take_counted() { return take_bytes(take<std::uint32_t>()); }
    std::string_view take_text() {
        const std::span<const std::uint8_t> bytes = take_counted();
        std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        if (is_cdr_ && text.ends_with('\0')) {
            text.remove_suffix(1);
        }
        return text;
    }
    /// std_msgs/Header. @return its stamp
    std::int64_t take_header(std::string_view* frame = nullptr) {
        if (!is_cdr_) {
            take<std::uint32_t>();  // sequence
        }
        const std::int64_t seconds = is_cdr_ ? take<std::int32_t>() : take<std::uint32_t>();
        const auto rest = take<std::uint32_t>();
        const std::string_view name = take_text();
        if (frame != nullptr) {
            *frame = name;
        }
        failed_ = failed_ || rest >= 1'000'000'000U;
        return seconds * 1'000'000'000 + rest;
    }
    template <std::size_t N>
    void skip_numbers() {
        for (std::size_t i = 0; i < N; ++i) {
            take<double>();
        }
    }

private:
    static constexpr std::size_t kCdrHead = 4;

    void align(std::size_t size) {
        if (is_cdr_) {
            const std::size_t step = std::min(size, most_aligned_);
            at_ = kCdrHead + (at_ - kCdrHead + step - 1) / step * step;
        }
    }
    std::span<const std::uint8_t> take_bytes(std::size_t count) {
        failed_ = failed_ || at_ > data_.size() || count > data_.size() - at_;
        if (failed_) {
            return {};
        }
        at_ += count;
        return data_.subspan(at_ - count, count);
    }

    bool is_cdr_;
    bool is_swapped_ = false;
    bool failed_ = false;
    std::size_t most_aligned_ = 8;
    std::span<const std::uint8_t> data_;
    std::size_t at_ = 0;
};

constexpr std::int64_t kMicrosecond = 1000;

/// PX4's messages have floats, and stamps in microseconds.
template <std::size_t N>
std::array<double, N> take_floats(WireReader& reader) {
    std::array<double, N> values{};
    for (double& value : values) {
        value = static_cast<double>(reader.take<float>());
    }
    return values;
}

template <std::size_t N>
void take_doubles(WireReader& reader, std::array<double, N>& values) {
    for (double& value : values) {
        value = reader.take<double>();
    }
}

WireReader reader_of(const BagMessage& message) { return {message.topic->wire, message.data}; }

}  // namespace

std::optional<RosKind> kind_of(std::string_view type) {
    if (type == "sensor_msgs/Image") {
        return RosKind::kImage;
    }
    if (type == "sensor_msgs/CompressedImage") {
        return RosKind::kCompressedImage;
    }
    if (type == "sensor_msgs/Imu" || type == "px4_msgs/SensorCombined") {
        return RosKind::kImu;
    }
    if (type == "sensor_msgs/CameraInfo") {
        return RosKind::kCameraInfo;
    }
    if (type == "tf2_msgs/TFMessage" || type == "tf/tfMessage") {
        return RosKind::kTransforms;
    }
    const bool is_pose = type == "geometry_msgs/PoseStamped" || type == "geometry_msgs/PoseWithCovarianceStamped" ||
                         type == "geometry_msgs/TransformStamped" || type == "nav_msgs/Odometry" ||
                         type == "px4_msgs/VehicleOdometry";
    return is_pose ? std::optional(RosKind::kPose) : std::nullopt;
}

bool read_message(const BagMessage& message, RosImage& image) {
    WireReader reader = reader_of(message);
    image = {};
    image.stamp_ns = reader.take_header(&image.frame);
    if (kind_of(message.topic->type) == RosKind::kImage) {
        image.height = reader.take<std::uint32_t>();
        image.width = reader.take<std::uint32_t>();
        image.encoding = reader.take_text();
        image.is_big_endian = reader.take<std::uint8_t>() != 0;
        image.step = reader.take<std::uint32_t>();
    } else {
        image.encoding = reader.take_text();
    }
    image.data = reader.take_counted();
    return !reader.failed();
}

bool read_message(const BagMessage& message, RosImu& imu) {
    WireReader reader = reader_of(message);
    imu = {};
    if (message.topic->type == "px4_msgs/SensorCombined") {
        imu.stamp_ns = static_cast<std::int64_t>(reader.take<std::uint64_t>()) * kMicrosecond;
        const std::array<double, 3> rate = take_floats<3>(reader);
        reader.take<std::uint32_t>();  // integration time of the gyroscope
        reader.take<std::int32_t>();   // the accelerometer's stamp against this one
        const std::array<double, 3> force = take_floats<3>(reader);
        imu.values = {rate[0], rate[1], rate[2], force[0], force[1], force[2]};
        return !reader.failed();
    }
    imu.stamp_ns = reader.take_header(&imu.frame);
    reader.skip_numbers<4 + 9>();  // orientation
    for (std::size_t i = 0; i < 3; ++i) {
        imu.values[i] = reader.take<double>();
    }
    reader.skip_numbers<9>();
    for (std::size_t i = 3; i < 6; ++i) {
        imu.values[i] = reader.take<double>();
    }
    return !reader.failed();
}

bool read_message(const BagMessage& message, RosPose& pose) {
    WireReader reader = reader_of(message);
    const std::string_view type = message.topic->type;
    if (type == "px4_msgs/VehicleOdometry") {
        reader.take<std::uint64_t>();  // when it was sent
        pose.stamp_ns = static_cast<std::int64_t>(reader.take<std::uint64_t>()) * kMicrosecond;
        reader.take<std::uint8_t>();  // NED or FRD: z downwards in both
        const std::array<double, 3> p = take_floats<3>(reader);
        const std::array<double, 4> q = take_floats<4>(reader);
        pose.values = {p[0], -p[1], -p[2], -q[1], q[0], -q[3], q[2]};
        return !reader.failed();
    }
    pose.stamp_ns = reader.take_header();
    if (type == "nav_msgs/Odometry" || type == "geometry_msgs/TransformStamped") {
        reader.take_text();  // frame of the body
    }
    for (const std::size_t i : {0U, 1U, 2U, 4U, 5U, 6U, 3U}) {  // ROS has w last
        pose.values[i] = reader.take<double>();
    }
    return !reader.failed();
}

bool read_message(const BagMessage& message, RosCameraInfo& info) {
    constexpr std::uint32_t kMostCoefficients = 64;
    WireReader reader = reader_of(message);
    info = {};
    reader.take_header(&info.frame);
    info.height = reader.take<std::uint32_t>();
    info.width = reader.take<std::uint32_t>();
    info.distortion_model = reader.take_text();
    const auto count = reader.take<std::uint32_t>();
    for (std::uint32_t i = 0; i < std::min(count, kMostCoefficients); ++i) {
        info.d.push_back(reader.take<double>());
    }
    take_doubles(reader, info.k);
    reader.skip_numbers<9>();  // the rotation that rectifies
    take_doubles(reader, info.p);
    return !reader.failed() && count <= kMostCoefficients;
}

bool read_message(const BagMessage& message, std::vector<RosTransform>& transforms) {
    constexpr std::uint32_t kMostTransforms = 4096;
    WireReader reader = reader_of(message);
    transforms.clear();
    const auto count = reader.take<std::uint32_t>();
    for (std::uint32_t i = 0; i < std::min(count, kMostTransforms) && !reader.failed(); ++i) {
        RosTransform& t = transforms.emplace_back();
        reader.take_header(&t.parent);
        t.child = reader.take_text();
        for (const std::size_t k : {0U, 1U, 2U, 4U, 5U, 6U, 3U}) {  // ROS has w last
            t.values[k] = reader.take<double>();
        }
    }
    return !reader.failed() && count <= kMostTransforms;
}

}  // namespace facet
