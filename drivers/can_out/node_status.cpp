// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/can_out/node_status.h"

namespace facet {
namespace {

constexpr std::uint32_t kLowPriority = 24;
constexpr std::uint8_t kSingleFrame = 0xC0;  // start and end of a transfer

constexpr std::uint8_t health_of(SinkState state) {
    switch (state) {
        case SinkState::kInit:
        case SinkState::kTracking: return 0;
        case SinkState::kDegraded: return 1;
        case SinkState::kLost: return 2;
    }
    return 2;
}

}  // namespace

CanFrame encode_node_status(const NodeStatus& status) {
    CanFrame frame;
    frame.extended = true;
    frame.id = (kLowPriority << 24U) | (NodeStatus::kMessageType << 8U) | (status.node_id & 0x7FU);
    frame.length = 8;
    for (unsigned i = 0; i < 4; ++i) {
        frame.bytes[i] = static_cast<std::uint8_t>(status.uptime_s >> (8 * i));
    }
    const unsigned mode = status.state == SinkState::kInit ? 1 : 0;
    frame.bytes[4] = static_cast<std::uint8_t>((health_of(status.state) << 6U) | (mode << 3U));
    frame.bytes[5] = static_cast<std::uint8_t>(status.reasons);
    frame.bytes[6] = static_cast<std::uint8_t>(status.reasons >> 8U);
    frame.bytes[7] = static_cast<std::uint8_t>(kSingleFrame | (status.transfer & 0x1FU));
    return frame;
}

}  // namespace facet
