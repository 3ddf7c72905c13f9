// SPDX-License-Identifier: BSD-2-Clause
// The payloads of the MAVLink messages that are sent or understood. Source: MAVLink's common.xml and minimal.xml.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "drivers/mavlink/frd.h"
#include "drivers/mavlink/mavlink_packet.h"

namespace facet {

// All functions: reentrant, no heap. Decoders take the payload of a packet of that message.

struct MavHeartbeat {
    std::uint8_t type = 18;          ///< MAV_TYPE_ONBOARD_CONTROLLER
    std::uint8_t autopilot = 8;      ///< MAV_AUTOPILOT_INVALID: no flight controller
    std::uint8_t base_mode = 0;      ///< MAV_MODE_FLAG bits
    std::uint8_t system_status = 0;  ///< MAV_STATE
    std::uint32_t custom_mode = 0;
};
inline constexpr std::uint8_t kMavAutopilotInvalid = 8;
inline constexpr std::uint8_t kMavModeArmed = 128;
inline constexpr std::uint8_t kMavStateCalibrating = 2;
inline constexpr std::uint8_t kMavStateActive = 4;
inline constexpr std::uint8_t kMavStateCritical = 5;
void encode(const MavHeartbeat& heartbeat, MavlinkPayload& payload);
MavHeartbeat decode_heartbeat(const MavlinkPayload& payload);

/// Asking: ts1 is the sender's time, tc1 zero. Answering: ts1 as asked, tc1 the answering side's time.
struct MavTimesync {
    std::int64_t tc1_ns = 0;
    std::int64_t ts1_ns = 0;
    MavlinkAddress target{0, 0};  ///< zeros: everybody, as from senders of the older protocol
};
void encode(const MavTimesync& timesync, MavlinkPayload& payload);
MavTimesync decode_timesync(const MavlinkPayload& payload);

/// COMMAND_LONG or COMMAND_INT; of the latter, only what it is and for whom.
struct MavCommand {
    std::array<float, 7> param{};
    std::uint16_t command = 0;
    MavlinkAddress target{0, 0};
};
inline constexpr std::uint16_t kMavCmdDoSetHome = 179;
inline constexpr std::uint16_t kMavCmdSetMessageInterval = 511;
inline constexpr std::uint16_t kMavCmdUser1 = 31010;
inline constexpr std::uint16_t kMavCmdUser2 = 31011;
MavCommand decode_command(const MavlinkPacket& packet);
/// COMMAND_LONG.
void encode(const MavCommand& command, MavlinkPayload& payload);

enum class MavResult : std::uint8_t {
    kAccepted = 0,
    kTemporarilyRejected = 1,
    kDenied = 2,
    kUnsupported = 3,
    kCommandLongOnly = 7,
};
struct MavCommandAck {
    std::uint16_t command = 0;
    MavResult result = MavResult::kAccepted;
    MavlinkAddress target{0, 0};
};
void encode(const MavCommandAck& ack, MavlinkPayload& payload);
/// The target of a sender that does not know that field is zero.
MavCommandAck decode_command_ack(const MavlinkPayload& payload);

enum class MavSeverity : std::uint8_t { kCritical = 2, kWarning = 4, kInfo = 6 };
/// Texts of more than 50 characters are cut.
void encode_status_text(MavSeverity severity, std::string_view text, MavlinkPayload& payload);

/// ODOMETRY: local frame LOCAL_FRD, body frame BODY_FRD, estimator type VIO. @param time_us  in the receiver's clock
void encode_odometry(const FrdOdometry& odometry, std::uint64_t time_us, MavlinkPayload& payload);
/// For firmware that does not know ODOMETRY.
void encode_vision_position(const FrdOdometry& odometry, std::uint64_t time_us, MavlinkPayload& payload);
void encode_vision_speed(const FrdOdometry& odometry, std::uint64_t time_us, MavlinkPayload& payload);

/// A place on the Earth (WGS 84).
struct GlobalOrigin {
    double latitude_deg = 0.0;   ///< [-90, 90]
    double longitude_deg = 0.0;  ///< [-180, 180]
    double altitude_m = 0.0;     ///< above mean sea level
};
/// SET_GPS_GLOBAL_ORIGIN. @param system  the autopilot's @param time_us  in the receiver's clock
void encode_set_origin(const GlobalOrigin& origin, std::uint8_t system, std::uint64_t time_us, MavlinkPayload& payload);

/// OBSTACLE_DISTANCE in the frame of the body, 72 sectors of 5 degrees. What is not known is sent as unknown
/// (UINT16_MAX), never as free (max_distance + 1).
void encode_obstacles(const ObstacleRanges& ranges, std::uint64_t time_us, MavlinkPayload& payload);

}  // namespace facet
