// SPDX-License-Identifier: BSD-2-Clause
// Bytes from the line to the flight controller, in pieces as they come.
#include "drivers/mavlink/mavlink_inertial.h"
#include "drivers/mavlink/mavlink_messages.h"
#include "drivers/mavlink/mavlink_parser.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    test::FuzzInput input(data, size);
    MavlinkParser parser;
    std::uint64_t packets = 0;
    while (!input.empty()) {
        const std::size_t piece = 1U + input.take<std::uint8_t>();
        const auto bytes = input.take_bytes(piece);
        test::require(parser.feed(bytes) == bytes.size());
        MavlinkPacket packet;
        std::span<const std::uint8_t> raw;
        while (ok(parser.next(packet, raw))) {
            const MavlinkMessageInfo* info = find_mavlink_message(static_cast<std::uint32_t>(packet.id));
            test::require(info != nullptr && packet.payload.size() >= info->size);
            switch (packet.id) {
                case MavlinkId::kHeartbeat: static_cast<void>(decode_heartbeat(packet.payload)); break;
                case MavlinkId::kTimesync: static_cast<void>(decode_timesync(packet.payload)); break;
                case MavlinkId::kCommandInt:
                case MavlinkId::kCommandLong: static_cast<void>(decode_command(packet)); break;
                case MavlinkId::kCommandAck: static_cast<void>(decode_command_ack(packet.payload)); break;
                case MavlinkId::kHighresImu:
                case MavlinkId::kRawImu:
                case MavlinkId::kScaledImu:
                case MavlinkId::kScaledImu2:
                case MavlinkId::kScaledImu3: static_cast<void>(decode_inertial(packet)); break;
                default: break;
            }
            ++packets;
        }
    }
    test::require(parser.counters().packets == packets);
    return 0;
}
