// SPDX-License-Identifier: BSD-2-Clause
// Signatures of MAVLink 2 frames.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "drivers/mavlink/mavlink_packet.h"
#include "platform/base/status.h"
#include "platform/base/timestamp.h"

namespace facet {

using MavlinkKey = std::array<std::uint8_t, 32>;

/// Signs frames and verifies those of others, as in MAVLink's guide "Message Signing":
///   signature = first 6 bytes of SHA-256(key + header + payload + checksum + link + time)
/// Time counts 10 us since 2015-01-01 in 48 bits and grows with every frame of a stream (system, component, link); a
/// frame that is not newer than the one before it has been played back and is refused, as is the first one of a stream
/// that is more than a minute older than the newest time known. Up to 16 streams. Across restarts the caller keeps
/// time(), or the wall clock has to be right. Thread-bound. No heap.
class MavlinkSigner {
public:
    MavlinkSigner(const MavlinkKey& key, std::uint8_t link) : key_(key), link_(link) {}

    /// The time goes on from there if that is later.
    void begin_at(std::uint64_t time) { time_ = std::max(time_, time); }
    /// Of the newest frame, sent or accepted.
    std::uint64_t time() const { return time_; }

    /// Appends the signature to an unsigned frame and renews its checksum. @param realtime  the wall clock
    void sign(MavlinkFrame& frame, Timestamp realtime);

    /// @param frame  a whole signed frame
    /// @return kCorrupt if the signature is wrong, kOutOfOrder if it is right but old, kFull if there are too many
    ///         streams
    Status verify(std::span<const std::uint8_t> frame, Timestamp realtime);

private:
    struct Stream {
        std::uint32_t name = 0;  ///< system, component and link in one
        std::uint64_t newest = 0;
    };
    void keep_up(Timestamp realtime);

    MavlinkKey key_;
    std::uint8_t link_;
    std::uint64_t time_ = 0;  ///< of the newest frame, sent or accepted, or the wall clock
    FixedVector<Stream, 16> streams_;
};

}  // namespace facet
