// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_can/dronecan.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace facet {
namespace {

constexpr std::uint8_t kStart = 0x80;
constexpr std::uint8_t kEnd = 0x40;
constexpr std::uint8_t kToggle = 0x20;
constexpr std::uint8_t kTransferMask = 0x1F;
constexpr std::uint32_t kServiceFlag = 0x80;
constexpr std::size_t kNeededPayload = 47;  // up to the end of the force integral

std::uint32_t little(std::span<const std::uint8_t> data, std::size_t at, int bytes) {
    std::uint32_t value = 0;
    for (int i = bytes - 1; i >= 0; --i) {
        value = (value << 8) | data[at + static_cast<std::size_t>(i)];
    }
    return value;
}

double float32_at(std::span<const std::uint8_t> data, std::size_t at) {
    return std::bit_cast<float>(little(data, at, 4));
}

Eigen::Vector3d float16_vector(std::span<const std::uint8_t> data, std::size_t at) {
    const auto element = [&](std::size_t i) {
        return float16_to_double(static_cast<std::uint16_t>(little(data, at + 2 * i, 2)));
    };
    return {element(0), element(1), element(2)};
}

Eigen::Vector3d float32_vector(std::span<const std::uint8_t> data, std::size_t at) {
    return {float32_at(data, at), float32_at(data, at + 4), float32_at(data, at + 8)};
}

std::uint16_t transfer_crc(std::span<const std::uint8_t> payload) {
    std::array<std::uint8_t, 8> signature{};
    for (std::size_t i = 0; i < signature.size(); ++i) {
        signature[i] = static_cast<std::uint8_t>(DroneCanDecoder::kSignature >> (8 * i));
    }
    return crc16_ccitt_false(payload, crc16_ccitt_false(signature));
}

}  // namespace

std::uint16_t crc16_ccitt_false(std::span<const std::uint8_t> data, std::uint16_t initial) {
    std::uint32_t crc = initial;
    for (const std::uint8_t byte : data) {
        crc ^= static_cast<std::uint32_t>(byte) << 8;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc & 0x8000U) != 0 ? (crc << 1) ^ 0x1021U : crc << 1;
        }
        crc &= 0xFFFFU;
    }
    return static_cast<std::uint16_t>(crc);
}

double float16_to_double(std::uint16_t bits) {
    const int exponent = (bits >> 10) & 0x1F;
    const int mantissa = bits & 0x3FF;
    double magnitude = 0.0;
    if (exponent == 0) {
        magnitude = std::ldexp(mantissa, -24);
    } else if (exponent < 31) {
        magnitude = std::ldexp(mantissa + 1024, exponent - 25);
    } else {
        magnitude = mantissa == 0 ? HUGE_VAL : std::nan("");
    }
    return (bits & 0x8000U) != 0 ? -magnitude : magnitude;
}

void DroneCanDecoder::reset() {
    receiving_ = false;
    transfer_known_ = false;
    size_ = 0;
    node_ = options_.node_id;
}

std::vector<CanFilter> DroneCanDecoder::filters() const {
    // Type and "no service" always; the node only if it is given.
    const bool known = options_.node_id >= 0;
    const std::uint32_t node = known ? static_cast<std::uint32_t>(options_.node_id) : 0U;
    return {{(std::uint32_t{kMessageType} << 8) | node, 0x00FFFF80U | (known ? 0x7FU : 0U), true}};
}

Status DroneCanDecoder::append(std::span<const std::uint8_t> bytes) {
    if (size_ + bytes.size() > buffer_.size()) {
        receiving_ = false;
        return Status::kCorrupt;
    }
    std::copy(bytes.begin(), bytes.end(), buffer_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += bytes.size();
    return Status::kNotReady;
}

Status DroneCanDecoder::take(const CanFrame& frame, std::span<const std::uint8_t>& payload) {
    if (frame.length < 1) {
        return Status::kCorrupt;
    }
    const std::uint8_t tail = frame.bytes[frame.length - 1U];
    const std::span<const std::uint8_t> bytes = frame.data().first(frame.length - 1U);
    const bool toggle = (tail & kToggle) != 0;
    if ((tail & kStart) != 0) {
        const bool interrupted = receiving_;
        if (toggle) {
            receiving_ = false;
            return Status::kCorrupt;
        }
        size_ = 0;
        toggle_ = false;
        transfer_ = tail & kTransferMask;
        first_stamp_ = frame.stamp;
        receiving_ = (tail & kEnd) == 0;
        if (!receiving_) {
            // On CAN FD the message fits into one frame, which has no CRC of its own.
            payload = bytes;
            return Status::kOk;
        }
        const Status appended = append(bytes);
        return interrupted ? Status::kCorrupt : appended;
    }
    if (!receiving_) {
        return Status::kNotFound;  // the start was addressed to others, or lost and reported then
    }
    if (toggle == toggle_ && (tail & kTransferMask) == transfer_) {
        return Status::kNotReady;  // sent twice by a controller that missed the acknowledgement
    }
    if (toggle == toggle_ || (tail & kTransferMask) != transfer_) {
        receiving_ = false;
        return Status::kCorrupt;
    }
    toggle_ = toggle;
    if (append(bytes) == Status::kCorrupt) {
        return Status::kCorrupt;
    }
    if ((tail & kEnd) == 0) {
        return Status::kNotReady;
    }
    receiving_ = false;
    if (size_ < 2) {
        return Status::kCorrupt;
    }
    const std::span<const std::uint8_t> all = std::span(buffer_).first(size_);
    if (transfer_crc(all.subspan(2)) != little(all, 0, 2)) {
        return Status::kCorrupt;
    }
    payload = all.subspan(2);
    return Status::kOk;
}

Status DroneCanDecoder::read(std::span<const std::uint8_t> payload, CanMeasurement& measurement) const {
    if (payload.size() < kNeededPayload) {
        return Status::kCorrupt;
    }
    CanMeasurement result;
    Eigen::Vector3d rate = float16_vector(payload, 11);
    Eigen::Vector3d force = float16_vector(payload, 29);
    const double interval_s = float32_at(payload, 7);
    const Eigen::Vector3d rate_integral = float32_vector(payload, 17);
    const Eigen::Vector3d force_integral = float32_vector(payload, 35);
    const bool filled = interval_s > 0.0 && interval_s < 1.0 && !force_integral.isZero() && rate_integral.allFinite() &&
                        force_integral.allFinite();
    if (options_.use_integrals && filled) {
        rate = rate_integral / interval_s;
        force = force_integral / interval_s;
        result.age = Duration::from_seconds(0.5 * interval_s);
    }
    if (!rate.allFinite() || !force.allFinite()) {
        return Status::kCorrupt;
    }
    result.rate = rate;
    result.force = force;
    measurement = result;
    return Status::kOk;
}

Status DroneCanDecoder::decode(const CanFrame& frame, CanMeasurement& measurement) {
    if (frame.error || !frame.extended || ((frame.id >> 8) & 0xFFFFU) != kMessageType ||
        (frame.id & kServiceFlag) != 0) {
        return Status::kNotFound;
    }
    const int node = static_cast<int>(frame.id & 0x7FU);
    if (node == 0 || (node_ >= 0 && node != node_)) {
        return Status::kNotFound;
    }
    node_ = node;
    std::span<const std::uint8_t> payload;
    FACET_TRY(take(frame, payload));
    FACET_TRY(read(payload, measurement));
    if (transfer_known_) {
        // The number wraps at 32, so that more than 31 lost in a row are miscounted.
        measurement.lost = (transfer_ - last_transfer_ - 1U) & kTransferMask;
    }
    last_transfer_ = transfer_;
    transfer_known_ = true;
    measurement.age = measurement.age + (frame.stamp - first_stamp_);
    return Status::kOk;
}

}  // namespace facet
