// SPDX-License-Identifier: BSD-2-Clause
// Finds MAVLink 2 frames in a stream of bytes.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "drivers/mavlink/mavlink_packet.h"
#include "platform/base/status.h"

namespace facet {

struct MavlinkParserCounters {
    std::uint64_t packets = 0;    ///< understood, checksum right
    std::uint64_t unknown = 0;    ///< frames of other messages: skipped, their checksums cannot be verified
    std::uint64_t lost = 0;       ///< frames that never arrived, by gaps of the senders' sequences
    std::uint64_t corrupt = 0;    ///< places that look like a frame, but whose checksum is wrong
    std::uint64_t skipped = 0;    ///< bytes that belong to no frame, frames of version 1 among them
    std::uint64_t version_1 = 0;  ///< heartbeats in frames of version 1: the other side speaks no version 2
};

/// Usage: while bytes come { parser.feed(bytes); while (ok(parser.next(packet))) use(packet); }
/// Whatever the bytes, work and memory are bounded: a byte is looked at once for each frame that it may be part of. A
/// wrong checksum costs the magic byte only; what follows it is searched again. A frame of an unknown message is
/// skipped as a whole if the next one begins behind it, or nothing follows yet. Frames with flags of incompatibility
/// that are not known are not touched. Thread-bound. No heap.
class MavlinkParser {
public:
    static constexpr std::size_t kCapacity = 1024;

    /// Takes what there is room for; everything if next() was called until it had no more, and at most
    /// kCapacity - 280 bytes come at a time. @return bytes taken
    std::size_t feed(std::span<const std::uint8_t> bytes);

    /// The next frame whose checksum is right.
    /// @param raw  its bytes, for verifying a signature; valid until the next feed()
    /// @return kNotReady if there is none yet: packet untouched
    Status next(MavlinkPacket& packet, std::span<const std::uint8_t>& raw);

    /// Forgets an unfinished frame: datagrams hold whole ones.
    void end_datagram();

    const MavlinkParserCounters& counters() const { return counters_; }

private:
    struct Sender {
        MavlinkAddress address;
        std::uint8_t sequence = 0;
    };
    enum class Verdict : std::uint8_t { kFrame, kUnknown, kNoFrame, kIncomplete };

    std::span<const std::uint8_t> waiting() const { return {bytes_.data() + begin_, end_ - begin_}; }
    static std::size_t frame_size(std::span<const std::uint8_t> bytes);
    static Verdict judge_version_1(std::span<const std::uint8_t> bytes);
    Verdict judge(std::span<const std::uint8_t> bytes);
    void follow_sequence(std::span<const std::uint8_t> frame);

    std::array<std::uint8_t, kCapacity> bytes_{};
    std::size_t begin_ = 0;
    std::size_t end_ = 0;
    FixedVector<Sender, 32> senders_;  ///< others' losses are not counted
    MavlinkParserCounters counters_;
};

}  // namespace facet
