// SPDX-License-Identifier: BSD-2-Clause
// Small bags of ROS 2: messages in CDR, little-endian, in an MCAP file.
#pragma once

#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "app/mcap/mcap_writer.h"

namespace facet::test {

/// Builds one message, aligning each number to its size.
class CdrMessage {
public:
    CdrMessage() : bytes_("\0\1\0\0", 4) {}

    template <class T>
    CdrMessage& put(T value) {
        while ((bytes_.size() - 4) % sizeof(T) != 0) {
            bytes_ += '\0';
        }
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
        return *this;
    }
    CdrMessage& text(const std::string& value) {
        put(static_cast<std::uint32_t>(value.size() + 1));
        bytes_ += value + '\0';
        return *this;
    }
    CdrMessage& header(std::int64_t stamp_ns, const std::string& frame) {
        put(static_cast<std::int32_t>(stamp_ns / 1'000'000'000));
        put(static_cast<std::uint32_t>(stamp_ns % 1'000'000'000));
        return text(frame);
    }
    CdrMessage& numbers(const std::vector<double>& values) {
        for (const double value : values) {
            put(value);
        }
        return *this;
    }
    CdrMessage& data(const std::string& value) {
        put(static_cast<std::uint32_t>(value.size()));
        bytes_ += value;
        return *this;
    }
    const std::string& bytes() const { return bytes_; }

private:
    std::string bytes_;
};

inline std::string cdr_image(std::int64_t stamp_ns, const std::string& frame, std::uint32_t width, std::uint32_t height,
                             const std::string& encoding, const std::string& pixels) {
    CdrMessage m;
    m.header(stamp_ns, frame).put(height).put(width).text(encoding).put(std::uint8_t{0});
    return m.put(static_cast<std::uint32_t>(pixels.size() / height)).data(pixels).bytes();
}

inline std::string cdr_imu(std::int64_t stamp_ns, const std::string& frame, const std::vector<double>& rates,
                           const std::vector<double>& forces) {
    CdrMessage m;
    m.header(stamp_ns, frame).numbers(std::vector<double>(13, 0.0)).numbers(rates);
    return m.numbers(std::vector<double>(9, 0.0)).numbers(forces).numbers(std::vector<double>(9, 0.0)).bytes();
}

inline std::string cdr_camera_info(const std::string& frame, std::uint32_t width, std::uint32_t height,
                                   const std::string& model, const std::vector<double>& d, const std::vector<double>& k,
                                   const std::vector<double>& p) {
    CdrMessage m;
    m.header(1, frame).put(height).put(width).text(model).put(static_cast<std::uint32_t>(d.size())).numbers(d);
    return m.numbers(k).numbers({1, 0, 0, 0, 1, 0, 0, 0, 1}).numbers(p).bytes();
}

struct Transform {
    std::string parent;
    std::string child;
    std::vector<double> values;  ///< translation x y z, quaternion x y z w
};
inline std::string cdr_transforms(const std::vector<Transform>& transforms) {
    CdrMessage m;
    m.put(static_cast<std::uint32_t>(transforms.size()));
    for (const Transform& t : transforms) {
        m.header(0, t.parent).text(t.child).numbers(t.values);
    }
    return m.bytes();
}

struct RecordedMessage {
    std::int64_t time_ns = 0;
    std::string topic;
    std::string type;
    std::string data;
};

inline void write_mcap_bag(const std::string& path, const std::vector<RecordedMessage>& messages) {
    McapWriter writer(path, Compression::kNone, "ros2", "test");
    std::map<std::string, std::uint16_t> channels;
    for (const RecordedMessage& m : messages) {
        if (!channels.contains(m.topic)) {
            channels[m.topic] =
                writer.add_channel(writer.add_schema(m.type, "ros2msg", "# none"), m.topic, "cdr", McapTexts{});
        }
        writer.add_message(channels[m.topic], static_cast<std::uint64_t>(m.time_ns), m.data);
    }
    writer.close();
}

}  // namespace facet::test
