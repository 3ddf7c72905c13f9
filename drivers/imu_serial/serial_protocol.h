// SPDX-License-Identifier: BSD-2-Clause
// What the protocols of inertial sensors on serial lines have in common.
#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>

namespace facet {

inline constexpr std::endian kBigEndian = std::endian::big;
inline constexpr std::endian kLittleEndian = std::endian::little;

/// What a packet says of one instant, in the sensor's axes.
struct SerialReading {
    std::optional<std::int64_t> time_ns;   ///< of the sensor's own clock
    std::optional<Eigen::Vector3d> rate;   ///< (rad/s)
    std::optional<Eigen::Vector3d> force;  ///< (m/s^2)
    std::optional<double> temperature_c;
    std::uint32_t lost = 0;  ///< packets missing before this one, where they are counted
};

/// What a stream of bytes begins with.
struct SerialFrame {
    enum class Kind : std::uint8_t {
        kNone,        ///< no packet
        kUnfinished,  ///< perhaps one: more bytes will tell
        kWhole,
        kDamaged,  ///< looks like one, but for its checksum
    };
    Kind kind = Kind::kNone;
    std::size_t size = 0;  ///< of a whole packet
};

/// A kind of packets. Thread-bound. No heap.
class SerialProtocol {
public:
    /// Nothing longer counts as a packet.
    static constexpr std::size_t kLongest = 1024;
    /// Later times count as impossible: 146 years.
    static constexpr std::uint64_t kLatest_ns = std::uint64_t{1} << 62U;

    virtual ~SerialProtocol() = default;
    virtual SerialFrame frame(std::span<const std::uint8_t> bytes) const = 0;
    /// @param packet  whole. @param reading  gains what the packet has
    virtual void read(std::span<const std::uint8_t> packet, SerialReading& reading) = 0;
    /// The line was opened again: counts and times restart.
    virtual void reset() = 0;
    /// Static words: which outputs of the sensor a sample is made of.
    virtual const char* outputs() const = 0;
};

/// Numbers of either order. @param bytes  at least as many as the number has
template <class Number, std::endian kOrder>
Number read_number(std::span<const std::uint8_t> bytes) {
    std::array<std::uint8_t, sizeof(Number)> own{};
    for (std::size_t i = 0; i < own.size(); ++i) {
        own[i] = bytes[kOrder == std::endian::native ? i : own.size() - 1 - i];
    }
    return std::bit_cast<Number>(own);
}

template <class Number, std::endian kOrder>
Eigen::Vector3d read_vector(std::span<const std::uint8_t> bytes) {
    Eigen::Vector3d v;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        v[static_cast<Eigen::Index>(axis)] =
            static_cast<double>(read_number<Number, kOrder>(bytes.subspan(axis * sizeof(Number))));
    }
    return v;
}

}  // namespace facet
