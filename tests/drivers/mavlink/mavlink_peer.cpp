// SPDX-License-Identifier: BSD-2-Clause
// Our side of the comparison with an independent implementation of MAVLink: node_mavlink_test.py.
//
// mavlink_peer emit     prints a line of JSON for one frame of every message that is sent: its bytes and its fields
// mavlink_peer absorb   reads frames, in hexadecimal digits, a line each, and prints the fields of what it understands
#include <array>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "drivers/mavlink/mavlink_inertial.h"
#include "drivers/mavlink/mavlink_messages.h"
#include "drivers/mavlink/mavlink_parser.h"
#include "drivers/mavlink/mavlink_range.h"
#include "drivers/mavlink/mavlink_signing.h"

namespace facet {
namespace {

using Json = nlohmann::ordered_json;

constexpr MavlinkKey kKey{0xde, 0xad, 0xbe, 0xef};
constexpr Timestamp kNow{1'750'000'000'123'456'789};

std::string hex_of(std::span<const std::uint8_t> bytes) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string hex;
    for (const std::uint8_t byte : bytes) {
        hex += kDigits[byte >> 4];
        hex += kDigits[byte & 15U];
    }
    return hex;
}

template <class Vector>
std::vector<float> floats(const Vector& v) {
    std::vector<float> list;
    for (Eigen::Index i = 0; i < v.size(); ++i) {
        list.push_back(static_cast<float>(v[i]));
    }
    return list;
}

std::vector<float> upper_triangle(const Matrix6d& m) {
    std::vector<float> list;
    for (Eigen::Index row = 0; row < 6; ++row) {
        for (Eigen::Index column = row; column < 6; ++column) {
            list.push_back(static_cast<float>(m(row, column)));
        }
    }
    return list;
}

FrdOdometry example() {
    Odometry o;
    o.p_W_B = {1.25, -2.5, 3.75};
    o.q_W_B = Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.1, -0.3, 0.9).normalized());
    o.v_W_B = {0.5, 1.5, -0.25};
    o.w_B = {0.1, -0.2, 0.3};
    for (int i = 0; i < 6; ++i) {
        o.pose_covariance(i, i) = 0.01 * (i + 1);
    }
    o.pose_covariance(0, 4) = o.pose_covariance(4, 0) = 0.003;
    o.quality = 87;
    o.reset_counter = 3;
    FrdOdometry frd;
    FACET_ASSERT(ok(to_frd(o, {0.2, {1, 2, 3}}, frd)));
    return frd;
}

class Emitter {
public:
    void emit(MavlinkId id, const MavlinkPayload& payload, const Json& fields, bool is_signed = false) {
        MavlinkFrame frame;
        pack_mavlink(id, {payload.data(), payload.size()}, {42, 197}, sequence_++, frame);
        if (is_signed) {
            signer_.sign(frame, kNow);
        }
        const MavlinkMessageInfo& info = *find_mavlink_message(static_cast<std::uint32_t>(id));
        std::cout << Json{{"id", static_cast<std::uint32_t>(id)},
                          {"crc_extra", info.crc_extra},
                          {"size", info.size},
                          {"signed", is_signed},
                          {"hex", hex_of({frame.data(), frame.size()})},
                          {"fields", fields}}
                         .dump()
                  << "\n";
    }

private:
    std::uint8_t sequence_ = 250;
    MavlinkSigner signer_{kKey, 7};
};

void emit_poses(Emitter& out) {
    MavlinkPayload payload;
    const FrdOdometry o = example();
    encode_odometry(o, 1'234'567'890'123, payload);
    const Json odometry{{"timeUsec", "1234567890123"},
                        {"x", floats(o.p_F)[0]},
                        {"y", floats(o.p_F)[1]},
                        {"z", floats(o.p_F)[2]},
                        {"q", floats(o.q_F_b_wxyz)},
                        {"vx", floats(o.v_b)[0]},
                        {"vy", floats(o.v_b)[1]},
                        {"vz", floats(o.v_b)[2]},
                        {"rollspeed", floats(o.w_b)[0]},
                        {"pitchspeed", floats(o.w_b)[1]},
                        {"yawspeed", floats(o.w_b)[2]},
                        {"poseCovariance", upper_triangle(o.pose_covariance)},
                        {"velocityCovariance", upper_triangle(o.twist_covariance)},
                        {"frameId", 20},
                        {"childFrameId", 12},
                        {"resetCounter", 3},
                        {"estimatorType", 3},
                        {"quality", 87}};
    out.emit(MavlinkId::kOdometry, payload, odometry);
    out.emit(MavlinkId::kOdometry, payload, odometry, true);
    encode_vision_position(o, 99, payload);
    out.emit(MavlinkId::kVisionPositionEstimate, payload,
             {{"usec", "99"},
              {"x", floats(o.p_F)[0]},
              {"y", floats(o.p_F)[1]},
              {"z", floats(o.p_F)[2]},
              {"roll", floats(o.rpy_rad)[0]},
              {"pitch", floats(o.rpy_rad)[1]},
              {"yaw", floats(o.rpy_rad)[2]},
              {"covariance", upper_triangle(o.pose_covariance)},
              {"resetCounter", 3}});
    encode_vision_speed(o, 99, payload);
    const Eigen::Matrix<double, 9, 1> covariance = o.v_F_covariance.reshaped();  // symmetric
    out.emit(MavlinkId::kVisionSpeedEstimate, payload,
             {{"usec", "99"},
              {"x", floats(o.v_F)[0]},
              {"y", floats(o.v_F)[1]},
              {"z", floats(o.v_F)[2]},
              {"covariance", floats(covariance)},
              {"resetCounter", 3}});
}

int emit() {
    Emitter out;
    MavlinkPayload payload;
    encode(MavHeartbeat{.system_status = kMavStateActive}, payload);
    const Json heartbeat{{"customMode", 0}, {"type", 18},        {"autopilot", 8},
                         {"baseMode", 0},   {"systemStatus", 4}, {"mavlinkVersion", 3}};
    out.emit(MavlinkId::kHeartbeat, payload, heartbeat);
    out.emit(MavlinkId::kHeartbeat, payload, heartbeat, true);
    encode(MavTimesync{0, 1'234'567'890'123'456'789, {1, 1}}, payload);
    out.emit(MavlinkId::kTimesync, payload,
             {{"tc1", "0"}, {"ts1", "1234567890123456789"}, {"targetSystem", 1}, {"targetComponent", 1}});
    encode(MavTimesync{-5, 7, {0, 0}}, payload);
    out.emit(MavlinkId::kTimesync, payload, {{"tc1", "-5"}, {"ts1", "7"}, {"targetSystem", 0}, {"targetComponent", 0}});
    encode(MavCommandAck{31010, MavResult::kTemporarilyRejected, {255, 190}}, payload);
    out.emit(MavlinkId::kCommandAck, payload,
             {{"command", 31010},
              {"result", 1},
              {"progress", 0},
              {"resultParam2", 0},
              {"targetSystem", 255},
              {"targetComponent", 190}});
    encode(MavCommand{{105.0F, 5000.0F}, kMavCmdSetMessageInterval, {1, 1}}, payload);
    out.emit(MavlinkId::kCommandLong, payload,
             {{"command", 511},
              {"_param1", 105.0},
              {"_param2", 5000.0},
              {"_param7", 0.0},
              {"confirmation", 0},
              {"targetSystem", 1},
              {"targetComponent", 1}});
    encode_status_text(MavSeverity::kWarning, "facet: DEGRADED few_features", payload);
    out.emit(MavlinkId::kStatusText, payload,
             {{"severity", 4}, {"text", "facet: DEGRADED few_features"}, {"id", 0}, {"chunkSeq", 0}});
    ObstacleRanges ranges;
    ranges.max_range_m = 12.0;
    Json distances = Json::array();
    for (std::size_t i = 0; i < ranges.range_m.size(); ++i) {
        const bool known = i % 3 != 0;
        ranges.range_m[i] = known ? 0.1F * static_cast<float>(i) : 99.0F;
        distances.push_back(known ? std::lround(10.0 * static_cast<double>(i)) : 65535);
    }
    encode_obstacles(ranges, 5'000'000, payload);
    out.emit(MavlinkId::kObstacleDistance, payload,
             {{"timeUsec", "5000000"},
              {"sensorType", 4},
              {"distances", distances},
              {"increment", 5},
              {"minDistance", 0},
              {"maxDistance", 1200},
              {"incrementF", 5.0},
              {"angleOffset", 0.0},
              {"frame", 12}});
    emit_poses(out);
    return 0;
}

Json fields_of(const MavlinkPacket& packet) {
    switch (packet.id) {
        case MavlinkId::kHeartbeat: {
            const MavHeartbeat h = decode_heartbeat(packet.payload);
            return {{"customMode", h.custom_mode},
                    {"type", h.type},
                    {"autopilot", h.autopilot},
                    {"baseMode", h.base_mode},
                    {"systemStatus", h.system_status}};
        }
        case MavlinkId::kTimesync: {
            const MavTimesync t = decode_timesync(packet.payload);
            return {{"tc1", std::to_string(t.tc1_ns)},
                    {"ts1", std::to_string(t.ts1_ns)},
                    {"targetSystem", t.target.system},
                    {"targetComponent", t.target.component}};
        }
        case MavlinkId::kCommandLong:
        case MavlinkId::kCommandInt: {
            const MavCommand c = decode_command(packet);
            return {{"command", c.command},
                    {"param1", c.param[0]},
                    {"param4", c.param[3]},
                    {"targetSystem", c.target.system},
                    {"targetComponent", c.target.component}};
        }
        case MavlinkId::kCommandAck: {
            const MavCommandAck a = decode_command_ack(packet.payload);
            return {{"command", a.command},
                    {"result", static_cast<int>(a.result)},
                    {"targetSystem", a.target.system},
                    {"targetComponent", a.target.component}};
        }
        case MavlinkId::kHighresImu:
        case MavlinkId::kRawImu:
        case MavlinkId::kScaledImu:
        case MavlinkId::kScaledImu2:
        case MavlinkId::kScaledImu3: {
            const MavInertial i = decode_inertial(packet);
            return {{"timeUs", std::to_string(i.time_us)},
                    {"force", floats(i.a_B)},
                    {"rate", floats(i.w_B)},
                    {"id", i.id},
                    {"complete", i.is_complete}};
        }
        case MavlinkId::kDistanceSensor: {
            const MavDistance d = decode_distance(packet.payload);
            return {{"timeMs", d.time_ms},  {"minCm", d.min_cm},
                    {"maxCm", d.max_cm},    {"distanceCm", d.distance_cm},
                    {"id", d.id},           {"orientation", d.orientation},
                    {"quality", d.quality}, {"isOfGround", d.is_of_ground()}};
        }
        default: return {};
    }
}

int absorb() {
    MavlinkParser parser;
    MavlinkSigner signer(kKey, 0);
    for (std::string line; std::getline(std::cin, line);) {
        std::vector<std::uint8_t> bytes;
        for (std::size_t i = 0; i + 1 < line.size(); i += 2) {
            bytes.push_back(static_cast<std::uint8_t>(std::stoi(line.substr(i, 2), nullptr, 16)));
        }
        (void)parser.feed(bytes);
        MavlinkPacket packet;
        for (std::span<const std::uint8_t> raw; ok(parser.next(packet, raw));) {
            const bool is_signed = (raw[2] & kMavlinkSigned) != 0;
            std::cout << Json{{"id", static_cast<std::uint32_t>(packet.id)},
                              {"system", packet.from.system},
                              {"component", packet.from.component},
                              {"sequence", packet.sequence},
                              {"signature", is_signed ? to_string(signer.verify(raw, kNow)) : "none"},
                              {"fields", fields_of(packet)}}
                             .dump()
                      << "\n";
        }
    }
    const MavlinkParserCounters& c = parser.counters();
    std::cout << Json{{"packets", c.packets}, {"unknown", c.unknown}, {"lost", c.lost}, {"corrupt", c.corrupt}}.dump()
              << "\n";
    return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
    const std::string mode = argc == 2 ? argv[1] : "";
    if (mode != "emit" && mode != "absorb") {
        std::cerr << "usage: mavlink_peer emit|absorb\n";
        return 2;
    }
    return mode == "emit" ? facet::emit() : facet::absorb();
}
