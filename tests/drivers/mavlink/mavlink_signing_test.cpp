// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_signing.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "drivers/mavlink/mavlink_messages.h"
#include "drivers/mavlink/sha256.h"

namespace facet::mavlink_signing_test {
namespace {

std::string hex_digest(const std::string& text, std::size_t piece) {
    Sha256 hash;
    for (std::size_t i = 0; i < text.size(); i += piece) {
        const std::string part = text.substr(i, piece);
        hash.add({reinterpret_cast<const std::uint8_t*>(part.data()), part.size()});
    }
    std::string hex;
    for (const std::uint8_t byte : hash.digest()) {
        constexpr const char* kDigits = "0123456789abcdef";
        hex += kDigits[byte >> 4];
        hex += kDigits[byte & 15U];
    }
    return hex;
}

TEST_CASE("SHA-256 gives the standard's examples, in whatever pieces the bytes come") {
    CHECK(hex_digest("", 1) == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    CHECK(hex_digest("abc", 1) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    const std::string two_blocks = "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq";
    for (const std::size_t piece : {1U, 7U, 56U}) {
        CHECK(hex_digest(two_blocks, piece) == "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    }
    const std::string million(1'000'000, 'a');
    CHECK(hex_digest(million, 999) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

MavlinkFrame heartbeat(std::uint8_t sequence) {
    MavlinkPayload payload;
    encode(MavHeartbeat{}, payload);
    MavlinkFrame frame;
    pack_mavlink(MavlinkId::kHeartbeat, {payload.data(), payload.size()}, {}, sequence, frame);
    return frame;
}

std::span<const std::uint8_t> bytes(const MavlinkFrame& frame) { return {frame.data(), frame.size()}; }

constexpr MavlinkKey kKey{1, 2, 3};
constexpr Timestamp kNow{1'700'000'000'000'000'000};

TEST_CASE("a signature is 13 bytes, and only the right key and unchanged bytes pass") {
    MavlinkSigner ours(kKey, 5);
    MavlinkSigner theirs(kKey, 0);
    MavlinkFrame frame = heartbeat(1);
    const std::size_t plain = frame.size();
    ours.sign(frame, kNow);
    CHECK(frame.size() == plain + 13);
    CHECK(frame[2] == 1);
    CHECK(frame[plain] == 5);
    for (std::size_t i = 0; i < frame.size(); ++i) {
        MavlinkFrame changed = frame;
        changed[i] ^= 0x10;
        INFO(i);
        CHECK(theirs.verify(bytes(changed), kNow) == Status::kCorrupt);
    }
    CHECK(theirs.verify(bytes(frame), kNow) == Status::kOk);
    MavlinkSigner stranger({1, 2, 4}, 0);
    CHECK(stranger.verify(bytes(frame), kNow) == Status::kCorrupt);
}

TEST_CASE("a frame that is played back is refused, in its stream and as the first of one") {
    MavlinkSigner ours(kKey, 5);
    MavlinkSigner theirs(kKey, 0);
    MavlinkFrame first = heartbeat(1);
    ours.sign(first, kNow);
    MavlinkFrame second = heartbeat(2);
    ours.sign(second, kNow);  // at the same instant, and later all the same
    CHECK(theirs.verify(bytes(first), kNow) == Status::kOk);
    CHECK(theirs.verify(bytes(second), kNow) == Status::kOk);
    CHECK(theirs.verify(bytes(second), kNow) == Status::kOutOfOrder);
    CHECK(theirs.verify(bytes(first), kNow) == Status::kOutOfOrder);
    MavlinkSigner later(kKey, 0);
    CHECK(later.verify(bytes(first), kNow + Duration::from_seconds(50.0)) == Status::kOk);
    MavlinkSigner much_later(kKey, 0);
    CHECK(much_later.verify(bytes(first), kNow + Duration::from_seconds(61.0)) == Status::kOutOfOrder);
}

TEST_CASE("streams beyond the sixteenth are refused") {
    MavlinkSigner theirs(kKey, 0);
    for (std::uint8_t link = 0; link < 17; ++link) {
        MavlinkSigner ours(kKey, link);
        MavlinkFrame frame = heartbeat(1);
        ours.sign(frame, kNow);
        CHECK(theirs.verify(bytes(frame), kNow) == (link < 16 ? Status::kOk : Status::kFull));
    }
}

}  // namespace
}  // namespace facet::mavlink_signing_test
