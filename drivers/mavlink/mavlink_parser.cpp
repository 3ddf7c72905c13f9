// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_parser.h"

#include <algorithm>

namespace facet {
namespace {

constexpr std::uint8_t kMagicOfVersion1 = 0xFE;
constexpr std::uint8_t kReordered = 128;  ///< a sequence that goes so far ahead has gone back

std::uint32_t id_of(std::span<const std::uint8_t> frame) {
    return frame[7] | std::uint32_t{frame[8]} << 8 | std::uint32_t{frame[9]} << 16;
}

}  // namespace

std::size_t MavlinkParser::feed(std::span<const std::uint8_t> bytes) {
    std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(begin_), bytes_.begin() + static_cast<std::ptrdiff_t>(end_),
              bytes_.begin());
    end_ -= begin_;
    begin_ = 0;
    const std::size_t taken = std::min(bytes.size(), kCapacity - end_);
    std::copy_n(bytes.begin(), taken, bytes_.begin() + static_cast<std::ptrdiff_t>(end_));
    end_ += taken;
    return taken;
}

void MavlinkParser::end_datagram() {
    counters_.skipped += end_ - begin_;
    begin_ = end_ = 0;
}

std::size_t MavlinkParser::frame_size(std::span<const std::uint8_t> bytes) {
    const std::size_t signature = (bytes[2] & kMavlinkSigned) != 0 ? kMavlinkSignatureSize : 0;
    return kMavlinkHeaderSize + bytes[1] + kMavlinkChecksumSize + signature;
}

/// Whether it is a heartbeat in a frame of version 1: magic 0xFE, length, sequence, system, component, message 0,
/// payload, checksum.
MavlinkParser::Verdict MavlinkParser::judge_version_1(std::span<const std::uint8_t> bytes) {
    constexpr std::size_t kHeader = 6;
    const MavlinkMessageInfo* const info = find_mavlink_message(static_cast<std::uint32_t>(MavlinkId::kHeartbeat));
    const std::size_t checksum = kHeader + info->size;
    const auto differs = [&](std::size_t i, std::uint8_t value) { return bytes.size() > i && bytes[i] != value; };
    if (differs(0, kMagicOfVersion1) || differs(1, info->size) || differs(kHeader - 1, 0)) {
        return Verdict::kNoFrame;
    }
    if (bytes.size() < checksum + kMavlinkChecksumSize) {
        return Verdict::kIncomplete;
    }
    const std::uint16_t body = mavlink_crc(bytes.subspan(1, checksum - 1));
    const std::uint16_t crc = mavlink_crc(std::span(&info->crc_extra, 1), body);
    return crc == (bytes[checksum] | bytes[checksum + 1] << 8) ? Verdict::kFrame : Verdict::kNoFrame;
}

/// @param bytes  begin with the magic byte
MavlinkParser::Verdict MavlinkParser::judge(std::span<const std::uint8_t> bytes) {
    if (bytes.size() < kMavlinkHeaderSize) {
        return Verdict::kIncomplete;
    }
    if ((bytes[2] & ~kMavlinkSigned) != 0) {
        return Verdict::kNoFrame;
    }
    const std::size_t size = frame_size(bytes);
    if (bytes.size() < size) {
        return Verdict::kIncomplete;
    }
    const MavlinkMessageInfo* const info = find_mavlink_message(id_of(bytes));
    if (info == nullptr) {
        const bool fits = bytes.size() == size || bytes[size] == kMavlinkMagic || bytes[size] == kMagicOfVersion1;
        return fits ? Verdict::kUnknown : Verdict::kNoFrame;
    }
    const std::size_t checksum = kMavlinkHeaderSize + bytes[1];
    const std::uint16_t crc = mavlink_checksum(bytes.first(checksum), info->crc_extra);
    if (crc == (bytes[checksum] | bytes[checksum + 1] << 8)) {
        return Verdict::kFrame;
    }
    ++counters_.corrupt;
    return Verdict::kNoFrame;
}

void MavlinkParser::follow_sequence(std::span<const std::uint8_t> frame) {
    const MavlinkAddress address{frame[5], frame[6]};
    auto* const known = std::ranges::find(senders_, address, &Sender::address);
    if (known == senders_.end()) {
        (void)senders_.try_push_back({address, frame[4]});  // when full, a stranger's losses are not counted
        return;
    }
    const auto gap = static_cast<std::uint8_t>(frame[4] - known->sequence - 1);
    counters_.lost += gap < kReordered ? gap : 0;
    known->sequence = frame[4];
}

Status MavlinkParser::next(MavlinkPacket& packet, std::span<const std::uint8_t>& raw) {
    while (begin_ < end_) {
        const std::span<const std::uint8_t> bytes = waiting();
        if (bytes[0] != kMavlinkMagic) {
            const Verdict heartbeat = judge_version_1(bytes);
            if (heartbeat == Verdict::kIncomplete) {
                return Status::kNotReady;
            }
            counters_.version_1 += heartbeat == Verdict::kFrame ? 1 : 0;
            ++begin_;
            ++counters_.skipped;
            continue;
        }
        const Verdict verdict = judge(bytes);
        if (verdict == Verdict::kIncomplete) {
            return Status::kNotReady;
        }
        if (verdict == Verdict::kNoFrame) {
            ++begin_;
            ++counters_.skipped;
            continue;
        }
        const std::size_t size = frame_size(bytes);
        begin_ += size;
        follow_sequence(bytes);
        if (verdict == Verdict::kUnknown) {
            ++counters_.unknown;
            continue;
        }
        ++counters_.packets;
        raw = bytes.first(size);
        packet.id = static_cast<MavlinkId>(id_of(raw));
        packet.from = {raw[5], raw[6]};
        packet.sequence = raw[4];
        packet.is_signed = false;
        packet.payload.clear();
        packet.payload.resize(std::max<std::size_t>(raw[1], find_mavlink_message(id_of(raw))->size));
        std::copy_n(raw.begin() + kMavlinkHeaderSize, raw[1], packet.payload.begin());
        return Status::kOk;
    }
    return Status::kNotReady;
}

}  // namespace facet
