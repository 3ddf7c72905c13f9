// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/signing_time.h"

#include <catch2/catch.hpp>

#include "drivers/mavlink/mavlink_messages.h"
#include "drivers/mavlink/mavlink_signing.h"
#include "tests/support/scripted_source.h"
#include "tests/support/temp_dir.h"

namespace facet::signing_time_test {
namespace {

MavlinkFrame signed_heartbeat(MavlinkSigner& signer, Timestamp realtime) {
    MavlinkPayload payload;
    encode(MavHeartbeat{}, payload);
    MavlinkFrame frame;
    pack_mavlink(MavlinkId::kHeartbeat, {payload.data(), payload.size()}, {1, 197}, 0, frame);
    signer.sign(frame, realtime);
    return frame;
}

TEST_CASE("an autopilot takes our signatures after a reboot that put the clock back by years") {
    const test::TempDir dir;
    const MavlinkKey key{1, 2, 3};
    const Timestamp right{1'790'000'000'000'000'000};
    const Timestamp without_clock{1'700'000'000'000'000'000};
    ManualClock clock;
    MavlinkSigner autopilot(key, 0);
    const auto takes = [&](const MavlinkFrame& frame) {
        return autopilot.verify({frame.data(), frame.size()}, right) == Status::kOk;
    };
    {
        SigningTime kept(dir.file("state"), clock);
        CHECK(kept.first() == 0);
        MavlinkSigner signer(key, 0);
        signer.begin_at(kept.first());
        for (int second = 0; second < 25; ++second) {
            CHECK(takes(signed_heartbeat(signer, right + Duration::from_seconds(second))));
            CHECK(kept.keep(signer.time()).empty());
            clock.advance(Duration::from_seconds(1.0));
        }
    }  // without a word: the power failed
    MavlinkSigner forgetful(key, 0);
    CHECK_FALSE(takes(signed_heartbeat(forgetful, without_clock)));
    const SigningTime kept(dir.file("state"), clock);
    MavlinkSigner signer(key, 0);
    signer.begin_at(kept.first());
    CHECK(takes(signed_heartbeat(signer, without_clock)));
    CHECK(takes(signed_heartbeat(signer, without_clock)));
    // A file that says nothing is as none; a clock that is right leads.
    CHECK(SigningTime("", clock).first() == 0);
    (void)dir.write("state/signing_time", "281474976710655\n");
    CHECK(SigningTime(dir.file("state"), clock).first() == 0);
    (void)dir.write("state/signing_time", "soon\n");
    CHECK(SigningTime(dir.file("state"), clock).first() == 0);
}

TEST_CASE("a time that cannot be kept is said once") {
    const test::TempDir dir;
    ManualClock clock;
    (void)dir.write("file", "");
    SigningTime kept(dir.file("file"), clock);
    CHECK(kept.keep(0).empty());
    CHECK_FALSE(kept.keep(5).empty());
    clock.advance(Duration::from_seconds(100.0));
    CHECK(kept.keep(6).empty());
}

}  // namespace
}  // namespace facet::signing_time_test
