// SPDX-License-Identifier: BSD-2-Clause
// MAVLink 2 frames: their layout, their checksum, and what is known of each message.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "platform/base/fixed_vector.h"

namespace facet {

/// CRC-16/MCRF4XX ("X.25" in MAVLink): polynomial 0x1021 reflected, initial 0xFFFF, no final inversion.
std::uint16_t mavlink_crc(std::span<const std::uint8_t> bytes, std::uint16_t initial = 0xFFFF);

struct MavlinkAddress {
    std::uint8_t system = 1;       ///< of the vehicle
    std::uint8_t component = 197;  ///< MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY
    bool operator==(const MavlinkAddress&) const = default;
};

/// Messages that are sent or understood, by their number.
enum class MavlinkId : std::uint32_t {
    kHeartbeat = 0,
    kScaledImu = 26,
    kRawImu = 27,
    kSetGpsGlobalOrigin = 48,
    kGpsGlobalOrigin = 49,
    kCommandInt = 75,
    kCommandLong = 76,
    kCommandAck = 77,
    kVisionPositionEstimate = 102,
    kVisionSpeedEstimate = 103,
    kHighresImu = 105,
    kTimesync = 111,
    kScaledImu2 = 116,
    kScaledImu3 = 129,
    kDistanceSensor = 132,
    kStatusText = 253,
    kObstacleDistance = 330,
    kOdometry = 331,
};

struct MavlinkMessageInfo {
    MavlinkId id;
    std::uint8_t crc_extra;  ///< checksum of the message's definition
    std::uint8_t size;       ///< of the payload with all extensions
};
/// nullptr for a message that is none of MavlinkId. Reentrant.
const MavlinkMessageInfo* find_mavlink_message(std::uint32_t id);

inline constexpr std::uint8_t kMavlinkMagic = 0xFD;  ///< of version 2
inline constexpr std::size_t kMavlinkHeaderSize = 10;
inline constexpr std::size_t kMavlinkChecksumSize = 2;
inline constexpr std::size_t kMavlinkSignatureSize = 13;
inline constexpr std::size_t kMavlinkMaxPayload = 255;
inline constexpr std::uint8_t kMavlinkSigned = 0x01;  ///< the only flag of incompatibility that there is

using MavlinkPayload = FixedVector<std::uint8_t, kMavlinkMaxPayload>;
/// Header, payload, checksum, signature.
using MavlinkFrame =
    FixedVector<std::uint8_t, kMavlinkHeaderSize + kMavlinkMaxPayload + kMavlinkChecksumSize + kMavlinkSignatureSize>;

/// A message as it was received, its checksum verified.
struct MavlinkPacket {
    MavlinkId id = MavlinkId::kHeartbeat;
    MavlinkAddress from;
    std::uint8_t sequence = 0;
    bool is_signed = false;  ///< and the signature is right
    MavlinkPayload payload;  ///< at least as long as the message with all extensions: zeros that were cut off are back
};

/// Puts a payload into an unsigned frame: zeros at its end are cut off, except the first byte. Reentrant. No heap.
void pack_mavlink(MavlinkId id, std::span<const std::uint8_t> payload, const MavlinkAddress& from,
                  std::uint8_t sequence, MavlinkFrame& frame);

/// Checksum of a frame's bytes up to and with the payload. @param frame  at least a header and its payload
std::uint16_t mavlink_checksum(std::span<const std::uint8_t> frame, std::uint8_t crc_extra);

/// Appends little-endian fields. MAVLink orders them by size, largest first, extensions after all others.
class MavlinkWriter {
public:
    explicit MavlinkWriter(MavlinkPayload& payload) : payload_(payload) { payload_.clear(); }

    template <class T>
    void put(T value) {
        for (std::size_t i = 0; i < sizeof(T); ++i) {
            payload_.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
        }
    }
    /// Adding zero makes -0 a +0: equal values give equal bytes.
    void put_float(double value) { put(std::bit_cast<std::uint32_t>(static_cast<float>(value) + 0.0F)); }
    template <class Vector>
    void put_vector(const Vector& v) {
        for (Eigen::Index i = 0; i < v.size(); ++i) {
            put_float(v[i]);
        }
    }

private:
    MavlinkPayload& payload_;
};

/// Takes fields from the front; past the end they are zero.
class MavlinkReader {
public:
    explicit MavlinkReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    template <class T>
    T take() {
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < sizeof(T) && at_ < bytes_.size(); ++i) {
            value |= std::uint64_t{bytes_[at_++]} << (8 * i);
        }
        return static_cast<T>(value);
    }
    float take_float() { return std::bit_cast<float>(take<std::uint32_t>()); }

private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;
};

}  // namespace facet
