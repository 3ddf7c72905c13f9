// SPDX-License-Identifier: BSD-2-Clause
// Decodes uavcan.equipment.ahrs.RawIMU of DroneCAN.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "drivers/imu_can/can_decoder.h"

namespace facet {

/// CRC-16/CCITT-FALSE: polynomial 0x1021, most significant bit first, not reflected, no final inversion.
std::uint16_t crc16_ccitt_false(std::span<const std::uint8_t> data, std::uint16_t initial = 0xFFFF);

/// IEEE 754 binary16 to double, infinities and NaN included.
double float16_to_double(std::uint16_t bits);

struct DroneCanOptions {
    int node_id = -1;  ///< only from this node; -1 for the first one heard
    /// Use the integrals, divided by their interval, when the node fills them: they have 24 bits of mantissa where the
    /// latest values have 11, and are free of aliasing. Their stamp is then the middle of the interval.
    bool use_integrals = true;
};

/// Reassembles transfers of message 1003 of one node, checks them and reads them.
/// Transport: DroneCAN specification 4.1 "CAN bus transport layer": identifier = priority (5 bits), message type (16),
/// 0, source node (7); the last byte of every frame has start, end, toggle and a 5-bit transfer number; transfers of
/// several frames start with a CRC over the type's signature and the payload. Message: dsdl
/// uavcan/equipment/ahrs/1003.RawIMU, little-endian: stamp 56 bits, interval f32, rate f16[3], rate integral f32[3],
/// force f16[3], force integral f32[3], then a covariance that is not used. Thread-bound. No heap after construction.
class DroneCanDecoder final : public CanDecoder {
public:
    static constexpr std::uint16_t kMessageType = 1003;
    static constexpr std::uint64_t kSignature = 0x8280632C40E574B5;
    static constexpr std::size_t kMaxPayload = 120;  ///< bytes, with 36 covariances

    explicit DroneCanDecoder(const DroneCanOptions& options = {}) : options_(options), node_(options.node_id) {}

    Status decode(const CanFrame& frame, CanMeasurement& measurement) override;
    std::vector<CanFilter> filters() const override;
    void reset() override;

private:
    Status take(const CanFrame& frame, std::span<const std::uint8_t>& payload);
    Status append(std::span<const std::uint8_t> bytes);
    Status read(std::span<const std::uint8_t> payload, CanMeasurement& measurement) const;

    DroneCanOptions options_;
    int node_;
    std::array<std::uint8_t, kMaxPayload + 2> buffer_{};  ///< CRC and payload
    std::size_t size_ = 0;
    bool receiving_ = false;
    bool toggle_ = false;
    std::uint8_t transfer_ = 0;
    std::uint8_t last_transfer_ = 0;  ///< number of the last complete transfer
    bool transfer_known_ = false;
    Timestamp first_stamp_;  ///< of the transfer's first frame
};

}  // namespace facet
