// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_serial/xsens.h"

#include <numeric>

namespace facet {
namespace {

constexpr std::uint8_t kPreamble = 0xFA;
constexpr std::uint8_t kMaster = 0xFF;
constexpr std::uint8_t kMtData2 = 0x36;
constexpr std::uint8_t kExtended = 0xFF;
constexpr std::size_t kMtHeader = 4;
constexpr unsigned kTemperature = 0x0810;
constexpr unsigned kPacketCounter = 0x1020;
constexpr unsigned kSampleTimeFine = 0x1060;
constexpr unsigned kAcceleration = 0x4020;
constexpr unsigned kRateOfTurn = 0x8020;
constexpr unsigned kFormat = 0x000F;  ///< of the number, and the frame of orientations
constexpr std::int64_t kTick_ns = 100'000;

/// @return nullopt for a format or length that is not known
std::optional<Eigen::Vector3d> vector_of(unsigned format, std::span<const std::uint8_t> value) {
    switch (format & 0x3U) {
        case 0: return value.size() == 12 ? std::optional(read_vector<float, kBigEndian>(value)) : std::nullopt;
        case 1:
            return value.size() == 12
                       ? std::optional<Eigen::Vector3d>(read_vector<std::int32_t, kBigEndian>(value) / double{1 << 20})
                       : std::nullopt;
        case 3: return value.size() == 24 ? std::optional(read_vector<double, kBigEndian>(value)) : std::nullopt;
        default: return std::nullopt;
    }
}

}  // namespace

SerialFrame Xsens::frame(std::span<const std::uint8_t> bytes) const {
    using Kind = SerialFrame::Kind;
    if (bytes[0] != kPreamble || (bytes.size() > 1 && bytes[1] != kMaster)) {
        return {};
    }
    if (bytes.size() < kMtHeader || (bytes[3] == kExtended && bytes.size() < kMtHeader + 2)) {
        return {Kind::kUnfinished};
    }
    const std::size_t length = bytes[3] == kExtended
                                   ? 2U + read_number<std::uint16_t, kBigEndian>(bytes.subspan(kMtHeader))
                                   : std::size_t{bytes[3]};
    const std::size_t size = kMtHeader + length + 1;
    if (size > kLongest) {
        return {};
    }
    if (bytes.size() < size) {
        return {Kind::kUnfinished};
    }
    const unsigned sum = std::accumulate(bytes.begin() + 1, bytes.begin() + static_cast<std::ptrdiff_t>(size), 0U);
    return {(sum & 0xFFU) == 0 ? Kind::kWhole : Kind::kDamaged, size};
}

void Xsens::read(std::span<const std::uint8_t> packet, SerialReading& reading) {
    if (packet[2] != kMtData2) {
        return;
    }
    std::size_t at = packet[3] == kExtended ? kMtHeader + 2 : kMtHeader;
    while (at + 3 < packet.size()) {
        const unsigned identifier = read_number<std::uint16_t, kBigEndian>(packet.subspan(at));
        const std::size_t length = packet[at + 2];
        at += 3;
        if (at + length + 1 > packet.size()) {
            return;  // an item that goes beyond the end
        }
        read_item(identifier, packet.subspan(at, length), reading);
        at += length;
    }
}

void Xsens::read_item(unsigned identifier, std::span<const std::uint8_t> value, SerialReading& reading) {
    if (identifier == kPacketCounter && value.size() == 2) {
        const auto count = read_number<std::uint16_t, kBigEndian>(value);
        reading.lost = any_count_ ? static_cast<std::uint16_t>(count - count_ - 1) : 0U;
        any_count_ = true;
        count_ = count;
    } else if (identifier == kSampleTimeFine && value.size() == 4) {
        const auto ticks = read_number<std::uint32_t, kBigEndian>(value);
        // A sensor that was reset counts from zero again: then time goes back, which the source sees.
        const auto passed = static_cast<std::int32_t>(ticks - ticks_);
        time_ns_ = any_time_ ? time_ns_ + passed * kTick_ns : std::int64_t{ticks} * kTick_ns;
        any_time_ = true;
        ticks_ = ticks;
        reading.time_ns = time_ns_;
    } else if ((identifier & ~kFormat) == kAcceleration) {
        reading.force = vector_of(identifier, value);
    } else if ((identifier & ~kFormat) == kRateOfTurn) {
        reading.rate = vector_of(identifier, value);
    } else if (identifier == kTemperature && value.size() == 4) {
        reading.temperature_c = read_number<float, kBigEndian>(value);
    }
}

}  // namespace facet
