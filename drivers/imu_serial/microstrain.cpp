// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_serial/microstrain.h"

#include <cmath>

namespace facet {
namespace {

constexpr std::uint8_t kSync1 = 0x75;
constexpr std::uint8_t kSync2 = 0x65;
constexpr std::uint8_t kSensorData = 0x80;
constexpr std::size_t kMipHeader = 4;
constexpr std::size_t kChecksum = 2;
constexpr std::uint8_t kScaledAccel = 0x04;
constexpr std::uint8_t kScaledGyro = 0x05;
constexpr std::uint8_t kGpsCorrelation = 0x12;
constexpr std::uint8_t kGpsTime = 0xD3;
constexpr std::uint8_t kReferenceTime = 0xD5;
constexpr std::size_t kVectorBytes = 12;
constexpr double kG = 9.80665;  ///< m/s^2
constexpr double kMostTime_s = 1e9;

bool is_intact(std::span<const std::uint8_t> packet) {
    std::uint8_t first = 0;
    std::uint8_t second = 0;
    for (const std::uint8_t byte : packet.first(packet.size() - kChecksum)) {
        first = static_cast<std::uint8_t>(first + byte);
        second = static_cast<std::uint8_t>(second + first);
    }
    return packet[packet.size() - 2] == first && packet[packet.size() - 1] == second;
}

void read_field(std::uint8_t descriptor, std::span<const std::uint8_t> value, SerialReading& reading) {
    if (descriptor == kScaledAccel && value.size() == kVectorBytes) {
        reading.force = kG * read_vector<float, kBigEndian>(value);
    } else if (descriptor == kScaledGyro && value.size() == kVectorBytes) {
        reading.rate = read_vector<float, kBigEndian>(value);
    } else if (descriptor == kReferenceTime && value.size() == 8) {
        if (const auto time_ns = read_number<std::uint64_t, kBigEndian>(value); time_ns < SerialProtocol::kLatest_ns) {
            reading.time_ns = static_cast<std::int64_t>(time_ns);
        }
    } else if ((descriptor == kGpsTime || descriptor == kGpsCorrelation) && value.size() == 12 && !reading.time_ns) {
        const auto time_s = read_number<double, kBigEndian>(value);
        if (time_s >= 0.0 && time_s < kMostTime_s) {
            reading.time_ns = std::llround(time_s * 1e9);
        }
    }
}

}  // namespace

SerialFrame MicroStrain::frame(std::span<const std::uint8_t> bytes) const {
    using Kind = SerialFrame::Kind;
    if (bytes[0] != kSync1 || (bytes.size() > 1 && bytes[1] != kSync2)) {
        return {};
    }
    if (bytes.size() < kMipHeader || bytes.size() < kMipHeader + bytes[3] + kChecksum) {
        return {Kind::kUnfinished};
    }
    const std::size_t size = kMipHeader + bytes[3] + kChecksum;
    return {is_intact(bytes.first(size)) ? Kind::kWhole : Kind::kDamaged, size};
}

void MicroStrain::read(std::span<const std::uint8_t> packet, SerialReading& reading) {
    if (packet[2] != kSensorData) {
        return;
    }
    const std::span<const std::uint8_t> payload = packet.subspan(kMipHeader, packet[3]);
    for (std::size_t at = 0; at + 2 <= payload.size();) {
        const std::size_t length = payload[at];
        if (length < 2 || at + length > payload.size()) {
            return;  // a field that goes beyond the end
        }
        read_field(payload[at + 1], payload.subspan(at + 2, length - 2), reading);
        at += length;
    }
}

}  // namespace facet
