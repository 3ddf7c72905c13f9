// SPDX-License-Identifier: BSD-2-Clause
#include "app/mcap/log_messages.h"

#include <fmt/format.h>

#include <algorithm>
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

constexpr const char* kPairSchema = R"json({
  "title": "facet.ImagePair", "type": "object",
  "description": "What was known of the images with this timestamp; the cameras' own stamps, 0 without an image",
  "properties": {
    "timestamp": {"type": "object", "title": "time", "properties": {
      "sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999}}},
    "frame_id": {"type": "string"},
    "left_stamp_ns": {"type": "integer"}, "right_stamp_ns": {"type": "integer"},
    "left_sequence": {"type": "integer", "description": "count of the camera"}, "right_sequence": {"type": "integer"},
    "left_exposure_ns": {"type": "integer", "description": "0: unknown"}, "right_exposure_ns": {"type": "integer"}},
  "required": ["timestamp", "frame_id", "left_stamp_ns", "right_stamp_ns", "left_sequence", "right_sequence",
    "left_exposure_ns", "right_exposure_ns"]
})json";

constexpr const char* kEdgeSchema = R"json({
  "title": "facet.TriggerEdge", "type": "object",
  "properties": {
    "timestamp": {"type": "object", "title": "time", "properties": {
      "sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999}}},
    "frame_id": {"type": "string"},
    "sequence": {"type": "integer", "description": "count of the line's edges"},
    "rising": {"type": "integer", "description": "1; 0 of a falling edge"}},
  "required": ["timestamp", "frame_id", "sequence", "rising"]
})json";

constexpr const char* kRangeSchema = R"json({
  "title": "facet.Range", "type": "object",
  "description": "Where the beam of a range finder met the ground, in the frame of the inertial sensor",
  "properties": {
    "timestamp": {"type": "object", "title": "time", "properties": {
      "sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999}}},
    "frame_id": {"type": "string"},
    "ground": {"type": "object", "description": "m", "properties": {
      "x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}}, "required": ["x", "y", "z"]},
    "given_ns": {"type": "integer", "description": "stamp of the frame before which it was given"}},
  "required": ["timestamp", "frame_id", "ground", "given_ns"]
})json";

/// Members of a message, and what they hold: numbers themselves, or those of an object's members of one letter.
struct Member {
    const char* object;  ///< in which it lies, or nullptr
    const char* name;
    std::string_view letters;  ///< empty: the member is a number
    const char* opening = "";  ///< text before it
    const char* closing = "";  ///< text behind it
};
constexpr std::array kImuMembers{Member{nullptr, "angular_velocity", "xyz"},
                                 Member{nullptr, "linear_acceleration", "xyz"}};
constexpr std::array kPoseMembers{Member{"pose", "position", "xyz", R"("pose":{)"},
                                  Member{"pose", "orientation", "wxyz", "", "}"}, Member{nullptr, "velocity", "xyz"},
                                  Member{nullptr, "gyroscope_bias", "xyz"},
                                  Member{nullptr, "accelerometer_bias", "xyz"}};
constexpr std::size_t kPoseAlone = 2;  ///< of these; the others may be missing, and count together only
constexpr std::size_t kPoseNumbers = 7;
constexpr std::array kPairMembers{Member{nullptr, "left_stamp_ns", ""},    Member{nullptr, "right_stamp_ns", ""},
                                  Member{nullptr, "left_sequence", ""},    Member{nullptr, "right_sequence", ""},
                                  Member{nullptr, "left_exposure_ns", ""}, Member{nullptr, "right_exposure_ns", ""}};
constexpr std::array kEdgeMembers{Member{nullptr, "sequence", ""}, Member{nullptr, "rising", ""}};

constexpr std::array kRangeMembers{Member{nullptr, "ground", "xyz"}, Member{nullptr, "given_ns", ""}};

std::span<const Member> members_of(LogTable table) {
    switch (table) {
        case LogTable::kImu: return kImuMembers;
        case LogTable::kTruth: return kPoseMembers;
        case LogTable::kPairs: return kPairMembers;
        case LogTable::kEdges: return kEdgeMembers;
        case LogTable::kRanges: return kRangeMembers;
        case LogTable::kLeft:
        case LogTable::kRight: break;
    }
    return {};
}

std::size_t numbers_in(const Member& member) { return std::max<std::size_t>(1, member.letters.size()); }

void begin_message(LogTable table, std::int64_t stamp_ns, std::string& out) {
    out.clear();
    fmt::format_to(std::back_inserter(out), R"({{"timestamp":{{"sec":{},"nsec":{}}},"frame_id":"{}")",
                   stamp_ns / kSecond, stamp_ns % kSecond, names_of(table).frame);
}

void add_member(const Member& member, std::span<const std::string_view> numbers, std::string& out) {
    const auto end = std::back_inserter(out);
    fmt::format_to(end, R"(,{}"{}":)", member.opening, member.name);
    if (member.letters.empty()) {
        out += numbers.front();
        return;
    }
    for (std::size_t i = 0; i < member.letters.size(); ++i) {
        fmt::format_to(end, R"({}"{}":{})", i == 0 ? "{" : ",", member.letters[i], numbers[i]);
    }
    fmt::format_to(end, "}}{}", member.closing);
}

/// @return false if it is neither a number nor null
bool take_number(const std::optional<std::string_view>& value, std::vector<std::string_view>& fields) {
    if (!value.has_value() || (*value != "null" && !is_json_number(*value))) {
        return false;
    }
    fields.push_back(*value == "null" ? "nan" : *value);
    return true;
}

/// Appends a member's numbers. @return false if one is missing or something else
bool take_member(const Member& member, std::string_view message, std::vector<std::string_view>& fields) {
    const std::optional<std::string_view> value =
        member.object != nullptr ? json_member(message, member.object, member.name) : json_member(message, member.name);
    if (member.letters.empty()) {
        return take_number(value, fields);
    }
    for (std::size_t i = 0; i < member.letters.size(); ++i) {
        if (!value.has_value() || !take_number(json_member(*value, member.letters.substr(i, 1)), fields)) {
            return false;
        }
    }
    return true;
}

}  // namespace

const LogTableNames& names_of(LogTable table) {
    static constexpr std::array<LogTableNames, kAllLogTables.size()> kNames{{
        {"cam0", "/cam0", "cam0", "foxglove.CompressedImage", "cam0/data.csv", "#timestamp [ns],filename\n"},
        {"cam1", "/cam1", "cam1", "foxglove.CompressedImage", "cam1/data.csv", "#timestamp [ns],filename\n"},
        {"imu0", "/imu0", "imu0", "facet.Imu", "imu0/data.csv",
         "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m "
         "s^-2],a_RS_S_z [m s^-2]\n"},
        {"state_groundtruth_estimate0", "/groundtruth", "world", "foxglove.PoseInFrame",
         "state_groundtruth_estimate0/data.csv", ""},  // never recorded
        {"", "/pairs", "pairs", "facet.ImagePair", "pairs.csv",
         "#timestamp [ns],left_stamp [ns],right_stamp [ns],left_sequence,right_sequence,left_exposure "
         "[ns],right_exposure [ns]\n"},
        {"trigger0", "/trigger0", "trigger0", "facet.TriggerEdge", "trigger0/data.csv",
         "#timestamp [ns],sequence,rising\n"},
        {"range0", "/range0", "imu0", "facet.Range", "range0/data.csv",
         "#timestamp [ns],x [m],y [m],z [m],given [ns]\n"},
    }};
    return kNames[static_cast<std::size_t>(table)];
}

const char* schema_of(LogTable table) {
    switch (table) {
        case LogTable::kLeft:
        case LogTable::kRight: return kImageSchema;
        case LogTable::kImu: return kImuSchema;
        case LogTable::kTruth: return kPoseSchema;
        case LogTable::kPairs: return kPairSchema;
        case LogTable::kEdges: return kEdgeSchema;
        case LogTable::kRanges: return kRangeSchema;
    }
    return "";
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

void write_row(LogTable table, std::int64_t stamp_ns, std::span<const std::string_view> fields, std::string& out) {
    begin_message(table, stamp_ns, out);
    for (const Member& member : members_of(table)) {
        if (fields.size() < numbers_in(member)) {
            break;
        }
        add_member(member, fields, out);
        fields = fields.subspan(numbers_in(member));
    }
    out += '}';
}

std::vector<std::string_view> read_row(LogTable table, std::string_view message) {
    std::vector<std::string_view> fields;
    std::size_t taken = 0;
    for (const Member& member : members_of(table)) {
        const std::size_t before = fields.size();
        if (!take_member(member, message, fields)) {
            const bool may_lack = table == LogTable::kTruth && taken >= kPoseAlone;
            fields.resize(may_lack ? std::min(before, kPoseNumbers) : 0);
            break;
        }
        ++taken;
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
