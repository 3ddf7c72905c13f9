// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_signing.h"

#include <algorithm>

#include "drivers/mavlink/sha256.h"

namespace facet {
namespace {

constexpr std::int64_t kEpoch_s = 1'420'070'400;  // 2015-01-01 00:00 UTC
constexpr std::uint64_t kMinute = 6'000'000;      // in units of 10 us
constexpr std::size_t kDigestUsed = 6;

/// @param signed_part  header to time, without the signature proper
Sha256Digest signature_of(const MavlinkKey& key, std::span<const std::uint8_t> signed_part) {
    Sha256 hash;
    hash.add(key);
    hash.add(signed_part);
    return hash.digest();
}

}  // namespace

void MavlinkSigner::keep_up(Timestamp realtime) {
    const std::int64_t since = realtime.ns / 10'000 - kEpoch_s * 100'000;
    time_ = std::max(time_, static_cast<std::uint64_t>(std::max<std::int64_t>(since, 0)));
}

void MavlinkSigner::sign(MavlinkFrame& frame, Timestamp realtime) {
    keep_up(realtime);
    ++time_;
    frame[2] |= kMavlinkSigned;
    const std::uint32_t id = frame[7] | std::uint32_t{frame[8]} << 8 | std::uint32_t{frame[9]} << 16;
    const std::size_t end = frame.size() - kMavlinkChecksumSize;
    const std::uint16_t crc = mavlink_checksum({frame.data(), end}, find_mavlink_message(id)->crc_extra);
    frame[end] = static_cast<std::uint8_t>(crc & 0xFFU);
    frame[end + 1] = static_cast<std::uint8_t>(crc >> 8);
    frame.push_back(link_);
    for (int shift = 0; shift < 48; shift += 8) {
        frame.push_back(static_cast<std::uint8_t>(time_ >> shift));
    }
    const Sha256Digest digest = signature_of(key_, {frame.data(), frame.size()});
    for (std::size_t i = 0; i < kDigestUsed; ++i) {
        frame.push_back(digest[i]);
    }
}

Status MavlinkSigner::verify(std::span<const std::uint8_t> frame, Timestamp realtime) {
    const std::size_t signed_size = frame.size() - kDigestUsed;
    const Sha256Digest digest = signature_of(key_, frame.first(signed_size));
    std::uint8_t difference = 0;  // in constant time
    for (std::size_t i = 0; i < kDigestUsed; ++i) {
        difference |= static_cast<std::uint8_t>(digest[i] ^ frame[signed_size + i]);
    }
    if (difference != 0) {
        return Status::kCorrupt;
    }
    std::uint64_t time = 0;
    for (std::size_t i = 0; i < 6; ++i) {
        time |= std::uint64_t{frame[signed_size - 6 + i]} << (8 * i);
    }
    const std::uint32_t name =
        std::uint32_t{frame[5]} << 16 | std::uint32_t{frame[6]} << 8 | std::uint32_t{frame[signed_size - 7]};
    keep_up(realtime);
    auto* const known = std::ranges::find(streams_, name, &Stream::name);
    if (known == streams_.end()) {
        if (time + kMinute < time_) {
            return Status::kOutOfOrder;
        }
        FACET_TRY(streams_.try_push_back({name, time}));
    } else if (time <= known->newest) {
        return Status::kOutOfOrder;
    } else {
        known->newest = time;
    }
    time_ = std::max(time_, time);
    return Status::kOk;
}

}  // namespace facet
