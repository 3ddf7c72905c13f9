// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_messages.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace facet {
namespace {

constexpr std::uint8_t kFrameBodyFrd = 12;
constexpr std::uint8_t kFrameLocalFrd = 20;
constexpr std::uint8_t kEstimatorVio = 3;
constexpr std::uint8_t kProtocolVersion = 3;
constexpr std::uint8_t kSensorUnknown = 4;  // MAV_DISTANCE_SENSOR: of the kinds that there are, none is a camera
constexpr std::uint16_t kRangeUnknown = std::numeric_limits<std::uint16_t>::max();
constexpr std::size_t kTextSize = 50;

/// Entries on and above the diagonal, row by row.
void put_upper_triangle(const Matrix6d& m, MavlinkWriter& out) {
    for (Eigen::Index row = 0; row < 6; ++row) {
        for (Eigen::Index column = row; column < 6; ++column) {
            out.put_float(m(row, column));
        }
    }
}

/// A range as OBSTACLE_DISTANCE has it: max_distance + 1 where nothing is, 65535 if that is unknown.
std::uint16_t centimetres(double range_m, double max_range_m) {
    if (std::isinf(range_m) && range_m > 0.0) {
        return static_cast<std::uint16_t>(centimetres(max_range_m, max_range_m) + 1);
    }
    if (!(range_m <= max_range_m)) {
        return kRangeUnknown;  // NaN, too
    }
    return static_cast<std::uint16_t>(std::clamp(std::lround(range_m * 100.0), 0L, 65'533L));
}

}  // namespace

void encode(const MavHeartbeat& heartbeat, MavlinkPayload& payload) {
    MavlinkWriter out(payload);
    out.put(heartbeat.custom_mode);
    out.put(heartbeat.type);
    out.put(heartbeat.autopilot);
    out.put(heartbeat.base_mode);
    out.put(heartbeat.system_status);
    out.put(kProtocolVersion);
}

MavHeartbeat decode_heartbeat(const MavlinkPayload& payload) {
    MavlinkReader in({payload.data(), payload.size()});
    MavHeartbeat heartbeat;
    heartbeat.custom_mode = in.take<std::uint32_t>();
    heartbeat.type = in.take<std::uint8_t>();
    heartbeat.autopilot = in.take<std::uint8_t>();
    heartbeat.base_mode = in.take<std::uint8_t>();
    heartbeat.system_status = in.take<std::uint8_t>();
    return heartbeat;
}

void encode(const MavTimesync& timesync, MavlinkPayload& payload) {
    MavlinkWriter out(payload);
    out.put(timesync.tc1_ns);
    out.put(timesync.ts1_ns);
    out.put(timesync.target.system);
    out.put(timesync.target.component);
}

MavTimesync decode_timesync(const MavlinkPayload& payload) {
    MavlinkReader in({payload.data(), payload.size()});
    MavTimesync timesync;
    timesync.tc1_ns = in.take<std::int64_t>();
    timesync.ts1_ns = in.take<std::int64_t>();
    timesync.target.system = in.take<std::uint8_t>();
    timesync.target.component = in.take<std::uint8_t>();
    return timesync;
}

MavCommand decode_command(const MavlinkPacket& packet) {
    MavlinkReader in({packet.payload.data(), packet.payload.size()});
    MavCommand command;
    for (float& param : command.param) {
        param = in.take_float();  // of COMMAND_INT, 5 and 6 are integers: not used
    }
    command.command = in.take<std::uint16_t>();
    command.target.system = in.take<std::uint8_t>();
    command.target.component = in.take<std::uint8_t>();
    return command;
}

void encode(const MavCommand& command, MavlinkPayload& payload) {
    MavlinkWriter out(payload);
    for (const float param : command.param) {
        out.put_float(static_cast<double>(param));
    }
    out.put(command.command);
    out.put(command.target.system);
    out.put(command.target.component);
    out.put(std::uint8_t{0});  // confirmation: the first transmission
}

MavCommandAck decode_command_ack(const MavlinkPayload& payload) {
    MavlinkReader in({payload.data(), payload.size()});
    MavCommandAck ack;
    ack.command = in.take<std::uint16_t>();
    ack.result = static_cast<MavResult>(in.take<std::uint8_t>());
    (void)in.take<std::uint8_t>();
    (void)in.take<std::int32_t>();
    ack.target.system = in.take<std::uint8_t>();
    ack.target.component = in.take<std::uint8_t>();
    return ack;
}

void encode(const MavCommandAck& ack, MavlinkPayload& payload) {
    MavlinkWriter out(payload);
    out.put(ack.command);
    out.put(static_cast<std::uint8_t>(ack.result));
    out.put(std::uint8_t{0});  // progress
    out.put(std::int32_t{0});  // result_param2
    out.put(ack.target.system);
    out.put(ack.target.component);
}

void encode_status_text(MavSeverity severity, std::string_view text, MavlinkPayload& payload) {
    MavlinkWriter out(payload);
    out.put(static_cast<std::uint8_t>(severity));
    for (std::size_t i = 0; i < kTextSize; ++i) {
        out.put(i < text.size() ? text[i] : '\0');
    }
    out.put(std::uint16_t{0});  // id: a text of one part
    out.put(std::uint8_t{0});
}

void encode_odometry(const FrdOdometry& odometry, std::uint64_t time_us, MavlinkPayload& payload) {
    MavlinkWriter out(payload);
    out.put(time_us);
    out.put_vector(odometry.p_F);
    out.put_vector(odometry.q_F_b_wxyz);
    out.put_vector(odometry.v_b);
    out.put_vector(odometry.w_b);
    put_upper_triangle(odometry.pose_covariance, out);
    put_upper_triangle(odometry.twist_covariance, out);
    out.put(kFrameLocalFrd);
    out.put(kFrameBodyFrd);
    out.put(odometry.reset_counter);
    out.put(kEstimatorVio);
    out.put(static_cast<std::int8_t>(odometry.quality));
}

void encode_vision_position(const FrdOdometry& odometry, std::uint64_t time_us, MavlinkPayload& payload) {
    MavlinkWriter out(payload);
    out.put(time_us);
    out.put_vector(odometry.p_F);
    out.put_vector(odometry.rpy_rad);
    put_upper_triangle(odometry.pose_covariance, out);
    out.put(odometry.reset_counter);
}

void encode_vision_speed(const FrdOdometry& odometry, std::uint64_t time_us, MavlinkPayload& payload) {
    MavlinkWriter out(payload);
    out.put(time_us);
    out.put_vector(odometry.v_F);
    for (Eigen::Index row = 0; row < 3; ++row) {
        out.put_vector(Eigen::Vector3d(odometry.v_F_covariance.row(row)));
    }
    out.put(odometry.reset_counter);
}

void encode_set_origin(const GlobalOrigin& origin, std::uint8_t system, std::uint64_t time_us,
                       MavlinkPayload& payload) {
    MavlinkWriter out(payload);
    out.put(static_cast<std::int32_t>(std::lround(origin.latitude_deg * 1e7)));
    out.put(static_cast<std::int32_t>(std::lround(origin.longitude_deg * 1e7)));
    out.put(static_cast<std::int32_t>(std::lround(origin.altitude_m * 1e3)));
    out.put(system);
    out.put(time_us);
}

void encode_obstacles(const ObstacleRanges& ranges, std::uint64_t time_us, MavlinkPayload& payload) {
    constexpr double kWidth_deg = 360.0 / ObstacleRanges::kSectors;
    MavlinkWriter out(payload);
    out.put(time_us);
    for (const float range_m : ranges.range_m) {
        out.put(centimetres(range_m, ranges.max_range_m));
    }
    out.put(std::uint16_t{0});  // min_distance
    out.put(centimetres(ranges.max_range_m, ranges.max_range_m));
    out.put(kSensorUnknown);
    out.put(static_cast<std::uint8_t>(kWidth_deg));
    out.put_float(kWidth_deg);
    out.put_float(0.0);  // angle_offset: sector 0 is ahead
    out.put(kFrameBodyFrd);
}

}  // namespace facet
