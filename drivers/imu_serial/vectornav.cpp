// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_serial/vectornav.h"

#include <array>

namespace facet {
namespace {

constexpr std::uint8_t kSync = 0xFA;
constexpr std::size_t kGroups = 6;
constexpr unsigned kFields = 15;
/// Bytes of each field of groups 1 to 6; 0: there is none.
constexpr std::array<std::array<std::uint8_t, kFields>, kGroups> kBytes{{
    {8, 8, 8, 12, 16, 12, 24, 12, 12, 24, 20, 28, 2, 4, 8},
    {8, 8, 8, 2, 8, 8, 8, 4, 4, 1},
    {2, 12, 12, 12, 4, 4, 16, 12, 12, 12, 12, 2},
    {8, 8, 2, 1, 1, 24, 24, 12, 12, 12, 4, 4, 2},
    {2, 12, 16, 36, 12, 12, 12, 12, 12, 12, 28, 24},
    {2, 24, 24, 12, 12, 12, 12, 12, 12, 4, 4, 68, 64},
}};

enum class Field : unsigned {
    kTimeStartup = 0x00,
    kImu = 0x09,
    kTimeOfTimeGroup = 0x10,
    kUncompAccel = 0x22,
    kUncompGyro = 0x23,
    kTemperature = 0x24
};

std::uint16_t crc(std::span<const std::uint8_t> bytes) {
    unsigned value = 0;
    for (const std::uint8_t byte : bytes) {
        value ^= static_cast<unsigned>(byte) << 8U;
        for (int bit = 0; bit < 8; ++bit) {
            value = ((value << 1U) ^ ((value & 0x8000U) != 0 ? 0x1021U : 0U)) & 0xFFFFU;
        }
    }
    return static_cast<std::uint16_t>(value);
}

std::size_t header_bytes(std::uint8_t groups) { return 2 + 2 * static_cast<std::size_t>(std::popcount(groups)); }

bool are_known(std::uint8_t groups) { return groups != 0 && groups < (1U << kGroups); }

/// Calls visit(field, offset) for each value. @param bytes  the header at least, of known groups
/// @return the packet's size, 0 if it has fields that nobody knows
template <class Visit>
std::size_t walk(std::span<const std::uint8_t> bytes, Visit visit) {
    std::size_t offset = header_bytes(bytes[1]);
    std::size_t word = 2;
    for (unsigned group = 0; group < kGroups; ++group) {
        if ((bytes[1] >> group & 1U) == 0) {
            continue;
        }
        const auto fields = read_number<std::uint16_t, kLittleEndian>(bytes.subspan(word));
        word += 2;
        for (unsigned field = 0; field < 16; ++field) {
            if ((fields >> field & 1U) == 0) {
                continue;
            }
            const std::size_t size = field < kFields ? kBytes[group][field] : 0U;
            if (size == 0) {
                return 0;
            }
            visit(static_cast<Field>(group << 4U | field), offset);
            offset += size;
        }
    }
    return offset + 2;
}

}  // namespace

SerialFrame VectorNav::frame(std::span<const std::uint8_t> bytes) const {
    using Kind = SerialFrame::Kind;
    if (bytes[0] != kSync) {
        return {};
    }
    if (bytes.size() < 2 || (are_known(bytes[1]) && bytes.size() < header_bytes(bytes[1]))) {
        return {Kind::kUnfinished};
    }
    const std::size_t size = are_known(bytes[1]) ? walk(bytes, [](Field, std::size_t) {}) : 0;
    if (size == 0 || size > kLongest) {
        return {};
    }
    if (bytes.size() < size) {
        return {Kind::kUnfinished};
    }
    return {crc(bytes.first(size).subspan(1)) == 0 ? Kind::kWhole : Kind::kDamaged, size};
}

void VectorNav::read(std::span<const std::uint8_t> packet, SerialReading& reading) {
    (void)walk(packet, [&](Field field, std::size_t offset) {
        const std::span<const std::uint8_t> value = packet.subspan(offset);
        switch (field) {
            case Field::kTimeStartup:
            case Field::kTimeOfTimeGroup:
                if (const auto time_ns = read_number<std::uint64_t, kLittleEndian>(value); time_ns < kLatest_ns) {
                    reading.time_ns = static_cast<std::int64_t>(time_ns);
                }
                break;
            case Field::kImu:
                reading.force = read_vector<float, kLittleEndian>(value);
                reading.rate = read_vector<float, kLittleEndian>(value.subspan(12));
                break;
            case Field::kUncompAccel: reading.force = read_vector<float, kLittleEndian>(value); break;
            case Field::kUncompGyro: reading.rate = read_vector<float, kLittleEndian>(value); break;
            case Field::kTemperature: reading.temperature_c = read_number<float, kLittleEndian>(value); break;
            default: break;
        }
    });
}

}  // namespace facet
