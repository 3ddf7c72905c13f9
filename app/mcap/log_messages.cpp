// SPDX-License-Identifier: BSD-2-Clause
#include "app/mcap/log_messages.h"

#include <fmt/format.h>

#include <iterator>
#include <optional>

#include "app/mcap/json_fields.h"

namespace facet {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

constexpr const char* kImageSchema = R"json({
  "title": "foxglove.CompressedImage", "type": "object",
  "properties": {
    "timestamp": {"type": "object", "title": "time", "properties": {
      "sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999}}},
    "frame_id": {"type": "string"},
    "format": {"type": "string", "description": "png"},
    "file": {"type": "string", "description": "name in the log, if it is not the stamp"},
    "data": {"type": "string", "contentEncoding": "base64"}},
  "required": ["timestamp", "frame_id", "data", "format"]
})json";

constexpr const char* kPoseSchema = R"json({
  "title": "foxglove.PoseInFrame", "type": "object",
  "properties": {
    "timestamp": {"type": "object", "title": "time", "properties": {
      "sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999}}},
    "frame_id": {"type": "string"},
    "pose": {"title": "foxglove.Pose", "type": "object", "properties": {
      "position": {"title": "foxglove.Vector3", "type": "object", "properties": {
        "x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}}, "required": ["x", "y", "z"]},
      "orientation": {"title": "foxglove.Quaternion", "type": "object", "properties": {
        "x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}, "w": {"type": "number"}},
        "required": ["x", "y", "z", "w"]}}, "required": ["position", "orientation"]},
    "velocity": {"type": "object", "description": "of the body in the frame (m/s)", "properties": {
      "x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}}},
    "gyroscope_bias": {"type": "object", "description": "rad/s", "properties": {
      "x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}}},
    "accelerometer_bias": {"type": "object", "description": "m/s^2", "properties": {
      "x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}}}},
  "required": ["timestamp", "frame_id", "pose"]
})json";

constexpr const char* kImuSchema = R"json({
  "title": "facet.Imu", "type": "object", "description": "A sample of an inertial sensor, in its own frame",
  "properties": {
    "timestamp": {"type": "object", "title": "time", "properties": {
      "sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999}}},
    "frame_id": {"type": "string"},
    "angular_velocity": {"type": "object", "description": "rad/s", "properties": {
      "x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}}, "required": ["x", "y", "z"]},
    "linear_acceleration": {"type": "object", "description": "specific force (m/s^2): +9.81 upwards at rest",
      "properties": {"x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}},
      "required": ["x", "y", "z"]}},
  "required": ["timestamp", "frame_id", "angular_velocity", "linear_acceleration"]
})json";

void begin_message(LogTable table, std::int64_t stamp_ns, std::string& out) {
    out.clear();
    fmt::format_to(std::back_inserter(out), R"({{"timestamp":{{"sec":{},"nsec":{}}},"frame_id":"{}")",
                   stamp_ns / kSecond, stamp_ns % kSecond, names_of(table).frame);
}

void add_vector(std::string_view name, std::span<const std::string_view> xyz, std::string& out) {
    fmt::format_to(std::back_inserter(out), R"(,"{}":{{"x":{},"y":{},"z":{}}})", name, xyz[0], xyz[1], xyz[2]);
}

/// Appends the members of an object that are numbers. @return false if one is missing or something else
template <class... Path>
bool take_numbers(std::string_view message, std::string_view names, std::vector<std::string_view>& fields,
                  Path... path) {
    const std::optional<std::string_view> object = json_member(message, path...);
    for (std::size_t i = 0; object.has_value() && i < names.size(); ++i) {
        const std::optional<std::string_view> value = json_member(*object, names.substr(i, 1));
        if (!value.has_value() || !is_json_number(*value)) {
            return false;
        }
        fields.push_back(*value);
    }
    return object.has_value();
}

}  // namespace

const LogTableNames& names_of(LogTable table) {
    static constexpr std::array<LogTableNames, 4> kNames{{
        {"cam0", "/cam0", "cam0", "foxglove.CompressedImage"},
        {"cam1", "/cam1", "cam1", "foxglove.CompressedImage"},
        {"imu0", "/imu0", "imu0", "facet.Imu"},
        {"state_groundtruth_estimate0", "/groundtruth", "world", "foxglove.PoseInFrame"},
    }};
    return kNames[static_cast<std::size_t>(table)];
}

const char* schema_of(LogTable table) {
    return is_camera(table) ? kImageSchema : table == LogTable::kImu ? kImuSchema : kPoseSchema;
}

void write_image(LogTable table, std::int64_t stamp_ns, std::string_view file, std::span<const std::uint8_t> image,
                 std::string& out) {
    begin_message(table, stamp_ns, out);
    out += R"(,"format":"png")";
    if (!file.empty()) {
        fmt::format_to(std::back_inserter(out), R"(,"file":"{}")", file);
    }
    out += R"(,"data":")";
    append_base64(image, out);
    out += R"("})";
}

void write_imu(std::int64_t stamp_ns, std::span<const std::string_view> fields, std::string& out) {
    begin_message(LogTable::kImu, stamp_ns, out);
    add_vector("angular_velocity", fields.first(3), out);
    add_vector("linear_acceleration", fields.subspan(3), out);
    out += '}';
}

void write_pose(std::int64_t stamp_ns, std::span<const std::string_view> fields, std::string& out) {
    begin_message(LogTable::kTruth, stamp_ns, out);
    fmt::format_to(std::back_inserter(out),
                   R"(,"pose":{{"position":{{"x":{},"y":{},"z":{}}},"orientation":{{"w":{},"x":{},"y":{},"z":{}}}}})",
                   fields[0], fields[1], fields[2], fields[3], fields[4], fields[5], fields[6]);
    if (fields.size() > 7) {
        add_vector("velocity", fields.subspan(7), out);
        add_vector("gyroscope_bias", fields.subspan(10), out);
        add_vector("accelerometer_bias", fields.subspan(13), out);
    }
    out += '}';
}

std::vector<std::string_view> read_imu(std::string_view message) {
    std::vector<std::string_view> fields;
    if (!take_numbers(message, "xyz", fields, "angular_velocity") ||
        !take_numbers(message, "xyz", fields, "linear_acceleration")) {
        fields.clear();
    }
    return fields;
}

std::vector<std::string_view> read_pose(std::string_view message) {
    std::vector<std::string_view> fields;
    if (!take_numbers(message, "xyz", fields, "pose", "position") ||
        !take_numbers(message, "wxyz", fields, "pose", "orientation")) {
        fields.clear();
        return fields;
    }
    const bool has_motion = json_member(message, "velocity").has_value();
    if (has_motion &&
        (!take_numbers(message, "xyz", fields, "velocity") || !take_numbers(message, "xyz", fields, "gyroscope_bias") ||
         !take_numbers(message, "xyz", fields, "accelerometer_bias"))) {
        fields.resize(7);
    }
    return fields;
}

std::string_view read_file_name(std::string_view message) {
    return json_plain_text(json_member(message, "file").value_or("")).value_or("");
}

bool read_image(std::string_view message, std::vector<std::uint8_t>& image) {
    const std::string_view data = json_member(message, "data").value_or("");
    return data.size() > 2 && data.front() == '"' && read_base64(data.substr(1, data.size() - 2), image);
}

}  // namespace facet
