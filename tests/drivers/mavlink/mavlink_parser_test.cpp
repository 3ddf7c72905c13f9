// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_parser.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "drivers/mavlink/mavlink_messages.h"
#include "tests/support/allocation_guard.h"

namespace facet::mavlink_parser_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes timesync(std::uint8_t sequence, std::int64_t ts1) {
    MavlinkPayload payload;
    encode(MavTimesync{0, ts1, {1, 197}}, payload);
    MavlinkFrame frame;
    pack_mavlink(MavlinkId::kTimesync, {payload.data(), payload.size()}, {1, 1}, sequence, frame);
    return {frame.begin(), frame.end()};
}

/// A frame of a message that is not known, right in itself.
Bytes stranger(std::uint8_t sequence, std::size_t size) {
    const Bytes header{kMavlinkMagic, static_cast<std::uint8_t>(size), 0, 0, sequence, 1, 1, 30, 0, 0};
    Bytes bytes(header.size() + size + 2, 0x55);
    std::copy(header.begin(), header.end(), bytes.begin());
    return bytes;
}

void append(Bytes& stream, const Bytes& bytes) { stream.insert(stream.end(), bytes.begin(), bytes.end()); }

/// What comes out of a stream that arrives in pieces.
std::vector<MavlinkPacket> parse(MavlinkParser& parser, const Bytes& stream, std::size_t piece) {
    std::vector<MavlinkPacket> packets;
    MavlinkPacket packet;
    std::span<const std::uint8_t> raw;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
        const std::size_t size = std::min(piece, stream.size() - at);
        REQUIRE(parser.feed(std::span(stream).subspan(at, size)) == size);
        while (ok(parser.next(packet, raw))) {
            packets.push_back(packet);
        }
    }
    return packets;
}

/// A heartbeat in a frame of version 1.
Bytes old_heartbeat(std::uint8_t sequence) {
    MavlinkPayload payload;
    encode(MavHeartbeat{.type = 2, .autopilot = 3, .base_mode = 0x81}, payload);
    Bytes frame{0xFE, static_cast<std::uint8_t>(payload.size()), sequence, 1, 1, 0};
    frame.insert(frame.end(), payload.begin(), payload.end());
    const std::uint8_t extra = find_mavlink_message(0)->crc_extra;
    const std::uint16_t crc = mavlink_crc(std::span(&extra, 1), mavlink_crc(std::span(frame).subspan(1)));
    frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
    return frame;
}

TEST_CASE("heartbeats of version 1 are noticed, in whatever pieces they come, and cost no frame of version 2") {
    Bytes stream;
    for (std::uint8_t i = 0; i < 20; ++i) {
        append(stream, old_heartbeat(i));
        append(stream, timesync(i, 1'000 + i));
        stream.push_back(0xFE);  // the beginning of one, and no more
        append(stream, timesync(static_cast<std::uint8_t>(100 + i), 2'000));
    }
    Bytes wrong = old_heartbeat(1);
    wrong[8] ^= 1U;
    append(stream, wrong);
    append(stream, timesync(20, 3'000));
    for (const std::size_t piece : {1U, 3U, 17U, 500U}) {
        MavlinkParser parser;
        CHECK(parse(parser, stream, piece).size() == 41);
        CHECK(parser.counters().version_1 == 20);
    }
}

TEST_CASE("frames come out whole however the bytes arrive; zeros that were cut off are back") {
    Bytes stream;
    for (std::uint8_t i = 0; i < 20; ++i) {
        append(stream, timesync(i, 1'000 + i));
        append(stream, stranger(static_cast<std::uint8_t>(100 + i), 28));
    }
    for (const std::size_t piece : {1U, 3U, 17U, 500U}) {
        MavlinkParser parser;
        const auto packets = parse(parser, stream, piece);
        REQUIRE(packets.size() == 20);
        for (std::size_t i = 0; i < packets.size(); ++i) {
            CHECK(packets[i].id == MavlinkId::kTimesync);
            CHECK(packets[i].from == MavlinkAddress{1, 1});
            CHECK(packets[i].payload.size() == 18);
            CHECK(decode_timesync(packets[i].payload).ts1_ns == static_cast<std::int64_t>(1'000 + i));
            CHECK(decode_timesync(packets[i].payload).target == MavlinkAddress{1, 197});
        }
        CHECK(parser.counters().unknown == 20);
        CHECK(parser.counters().corrupt == 0);
        CHECK(parser.counters().skipped == 0);
    }
}

TEST_CASE("gaps of the sequence are frames lost, also over its end; a repeated frame is not") {
    Bytes stream;
    for (const int sequence : {250, 251, 254, 1, 1, 2}) {  // 252, 253; 255, 0
        append(stream, timesync(static_cast<std::uint8_t>(sequence), 5));
    }
    append(stream, stranger(5, 9));  // 3, 4
    MavlinkParser parser;
    CHECK(parse(parser, stream, 64).size() == 6);
    CHECK(parser.counters().lost == 6);
}

TEST_CASE("a damaged frame is left out, and the next one is found") {
    const Bytes good = timesync(2, 77);
    const Bytes first = timesync(1, 77);
    for (std::size_t i = 0; i < first.size(); ++i) {
        Bytes stream = first;
        stream[i] ^= 0x04;
        for (int k = 0; k < 12; ++k) {  // a length that has grown may claim what follows
            append(stream, good);
        }
        MavlinkParser parser;
        INFO(i);
        CHECK(parse(parser, stream, 30).size() >= 12);
        CHECK(parser.counters().packets <= 13);
    }
}

TEST_CASE("flags that are not understood, and the protocol's first version, are passed over") {
    Bytes flagged = timesync(1, 5);
    flagged[2] = 0x02;
    Bytes stream = flagged;
    append(stream, {0xFE, 9, 0, 1, 1, 0, 0, 0, 0, 0, 18, 8, 0, 4, 3, 0x11, 0x22});
    append(stream, timesync(2, 6));
    MavlinkParser parser;
    const auto packets = parse(parser, stream, stream.size());
    REQUIRE(packets.size() == 1);
    CHECK(packets[0].sequence == 2);
    CHECK(parser.counters().corrupt == 0);
}

TEST_CASE("what a datagram leaves unfinished does not hold back the next one") {
    MavlinkParser parser;
    CHECK(parse(parser, {kMavlinkMagic, 255, 0, 0, 1, 1, 1, 111, 0, 0, 1, 2}, 100).empty());
    parser.end_datagram();
    CHECK(parse(parser, timesync(1, 5), 100).size() == 1);
    CHECK(parser.counters().skipped == 12);
}

/// Noise in which magic bytes, known numbers and whole frames are frequent.
Bytes noise(std::mt19937& random, int& frames) {
    Bytes stream;
    const auto draw = [&](int end) { return std::uniform_int_distribution<int>(0, end - 1)(random); };
    for (int i = 0; i < 40; ++i) {
        switch (draw(6)) {
            case 0:
                append(stream, timesync(static_cast<std::uint8_t>(draw(256)), 1'234'567));
                ++frames;
                break;
            case 1:
                append(stream, stranger(static_cast<std::uint8_t>(draw(256)), static_cast<std::size_t>(draw(256))));
                break;
            case 2: {  // cut short
                Bytes cut = timesync(3, 99);
                cut.resize(static_cast<std::size_t>(draw(static_cast<int>(cut.size()))));
                append(stream, cut);
                break;
            }
            case 3:
                append(stream, {kMavlinkMagic, static_cast<std::uint8_t>(draw(256)), 0, 0, 1, 1, 1, 111, 0, 0});
                break;
            default:
                for (int k = draw(60); k > 0; --k) {
                    stream.push_back(draw(4) == 0 ? kMavlinkMagic : static_cast<std::uint8_t>(draw(256)));
                }
        }
    }
    return stream;
}

TEST_CASE(
    "whatever comes, nothing is read or written out of bounds, every byte is accounted for, and no heap is used") {
    std::mt19937 random(20'240'229);
    int sent = 0;
    std::uint64_t found = 0;
    for (int run = 0; run < 3'000; ++run) {
        const Bytes stream = noise(random, sent);
        MavlinkParser parser;
        MavlinkPacket packet;
        std::span<const std::uint8_t> raw;
        std::size_t at = 0;
        std::size_t bytes_of_frames = 0;
        const test::AllocationGuard guard;
        bool all_taken = true;
        while (at < stream.size()) {
            const std::size_t piece = std::min<std::size_t>(stream.size() - at, 1U + random() % 512U);
            all_taken = all_taken && parser.feed(std::span(stream).subspan(at, piece)) == piece;
            at += piece;
            while (ok(parser.next(packet, raw))) {
                bytes_of_frames += raw.size();
            }
        }
        parser.end_datagram();
        const auto allocations = guard.allocations();
        CHECK(allocations == 0);
        CHECK(all_taken);
        CHECK(bytes_of_frames + parser.counters().skipped <= stream.size());  // the rest are strangers' frames
        found += parser.counters().packets;
    }
    // Some frames lie inside what a stranger claims; none may be invented.
    CHECK(found <= static_cast<std::uint64_t>(sent));
    CHECK(found > static_cast<std::uint64_t>(0.6 * sent));
}

}  // namespace
}  // namespace facet::mavlink_parser_test
