// SPDX-License-Identifier: BSD-2-Clause
// uavcan.protocol.NodeStatus of DroneCAN: that this node is alive, and how it is.
#pragma once

#include <cstdint>

#include "drivers/common/can_frame.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// Message 341 in one frame. Transport: DroneCAN specification 4.1; identifier = priority (5 bits; 24, low), message
/// type (16), 0, source node (7). Payload, dsdl uavcan/protocol/341.NodeStatus: uptime 32 bits little-endian; health (2
/// bits), mode (3), sub-mode (3) from the most significant bit on; the vendor's status code, 16 bits little-endian:
/// here the lower 16 reasons of health.csv. The last byte has start, end, toggle and a 5-bit transfer number.
///   | state       | health   | mode           |
///   |-------------|----------|----------------|
///   | kInit       | OK       | INITIALIZATION |
///   | kTracking   | OK       | OPERATIONAL    |
///   | kDegraded   | WARNING  | OPERATIONAL    |
///   | kLost       | ERROR    | OPERATIONAL    |
struct NodeStatus {
    static constexpr std::uint32_t kMessageType = 341;

    std::uint8_t node_id = 1;  ///< 1 to 127
    std::uint32_t uptime_s = 0;
    SinkState state = SinkState::kInit;
    std::uint32_t reasons = 0;
    std::uint8_t transfer = 0;  ///< one more in each frame; 5 bits count
};

/// Reentrant. No heap.
CanFrame encode_node_status(const NodeStatus& status);

}  // namespace facet
