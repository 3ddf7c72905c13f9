// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_packet.h"

#include <algorithm>
#include <array>

namespace facet {
namespace {

// CRC_EXTRA and sizes as in the generated headers of MAVLink's `common` set; tests/drivers/mavlink compares them with
// those of an independent implementation.
constexpr std::array<MavlinkMessageInfo, 18> kMessages{{
    {MavlinkId::kHeartbeat, 50, 9},
    {MavlinkId::kScaledImu, 170, 24},
    {MavlinkId::kRawImu, 144, 29},
    {MavlinkId::kSetGpsGlobalOrigin, 41, 21},
    {MavlinkId::kGpsGlobalOrigin, 39, 20},
    {MavlinkId::kCommandInt, 158, 35},
    {MavlinkId::kCommandLong, 152, 33},
    {MavlinkId::kCommandAck, 143, 10},
    {MavlinkId::kVisionPositionEstimate, 158, 117},
    {MavlinkId::kVisionSpeedEstimate, 208, 57},
    {MavlinkId::kHighresImu, 93, 63},
    {MavlinkId::kTimesync, 34, 18},
    {MavlinkId::kScaledImu2, 76, 24},
    {MavlinkId::kScaledImu3, 46, 24},
    {MavlinkId::kDistanceSensor, 85, 39},
    {MavlinkId::kStatusText, 83, 54},
    {MavlinkId::kObstacleDistance, 23, 167},
    {MavlinkId::kOdometry, 91, 233},
}};

}  // namespace

std::uint16_t mavlink_crc(std::span<const std::uint8_t> bytes, std::uint16_t initial) {
    std::uint32_t crc = initial;
    for (const std::uint8_t byte : bytes) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc & 1U) != 0 ? (crc >> 1) ^ 0x8408U : crc >> 1;
        }
    }
    return static_cast<std::uint16_t>(crc);
}

const MavlinkMessageInfo* find_mavlink_message(std::uint32_t id) {
    const auto* const found = std::ranges::find(kMessages, static_cast<MavlinkId>(id), &MavlinkMessageInfo::id);
    return found == kMessages.end() ? nullptr : found;
}

std::uint16_t mavlink_checksum(std::span<const std::uint8_t> frame, std::uint8_t crc_extra) {
    const std::uint16_t body = mavlink_crc(frame.subspan(1, kMavlinkHeaderSize - 1 + frame[1]));
    return mavlink_crc(std::span(&crc_extra, 1), body);
}

void pack_mavlink(MavlinkId id, std::span<const std::uint8_t> payload, const MavlinkAddress& from,
                  std::uint8_t sequence, MavlinkFrame& frame) {
    std::size_t size = payload.size();
    while (size > 1 && payload[size - 1] == 0) {
        --size;
    }
    const auto number = static_cast<std::uint32_t>(id);
    const std::array<std::uint8_t, kMavlinkHeaderSize> header{kMavlinkMagic,
                                                              static_cast<std::uint8_t>(size),
                                                              0,
                                                              0,
                                                              sequence,
                                                              from.system,
                                                              from.component,
                                                              static_cast<std::uint8_t>(number & 0xFFU),
                                                              static_cast<std::uint8_t>((number >> 8) & 0xFFU),
                                                              static_cast<std::uint8_t>(number >> 16)};
    frame.resize(kMavlinkHeaderSize + size);
    std::copy(header.begin(), header.end(), frame.begin());
    std::copy_n(payload.begin(), size, frame.begin() + kMavlinkHeaderSize);
    const std::uint16_t crc = mavlink_checksum({frame.data(), frame.size()}, find_mavlink_message(number)->crc_extra);
    frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
}

}  // namespace facet
