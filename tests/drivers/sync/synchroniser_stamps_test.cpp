// SPDX-License-Identifier: BSD-2-Clause
// Trigger wires that break, and cameras that no wire joins.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>

#include "drivers/sync/synchroniser.h"
#include "tests/drivers/sync/sync_world.h"

namespace facet::synchroniser_stamps_test {
namespace {

using test::check_no_wrong_pair;
using test::Given;
using test::kMs;
using test::Outcome;
using test::reported;
using test::run;
using test::views;
using test::World;

TEST_CASE("a trigger wire that breaks: the cameras' own stamps take its place, and the edges again when they return") {
    World world;
    world.left_delay_ns = 6 * kMs;
    world.right_delay_ns = 9 * kMs;
    for (int event = 80; event < 140; ++event) {
        world.edge_vanished.insert(event);  // not counted: the line is requested anew
    }
    SynchroniserOptions options;
    options.trigger_silence = {250 * kMs};
    Synchroniser sync(options);
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 3 * kMs);  // of the stamps' jitter, not of the delays, which were seen before
    CHECK(reported(outcome, SyncFault::kTriggerSilent));
    CHECK(sync.count(SyncFault::kUnsynchronised) == 0);
    CHECK(views(outcome, 86, 140, true, true) >= 52);
    CHECK(views(outcome, 141, 200, true, true) == 59);  // by edges at once
    for (const Given& g : outcome.given) {
        INFO("event " << g.event());
        if (g.event() < 80 || g.event() > 141) {
            REQUIRE(!g.is_by_stamps);
            REQUIRE(g.stamp_error_ns == 0);
        } else if (g.event() >= 86 && g.event() < 139) {
            REQUIRE(g.is_by_stamps);  // says so, whatever the error
        }
    }
    CHECK(outcome.allocations == 0);
    CHECK(outcome.released == outcome.frames);
}

TEST_CASE("a trigger wire that is dead from the start does not keep the vehicle blind") {
    World world;
    world.trigger = false;
    world.stamp_jitter_ms = 0.0;
    SynchroniserOptions options;
    options.trigger_silence = {250 * kMs};
    Synchroniser sync(options);
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 3 * kMs);
    CHECK(views(outcome, 10, 200, true, true) >= 188);
    CHECK(outcome.given.front().event() == 1);  // known at the sixth frame, while four of each camera wait
    CHECK(std::all_of(outcome.given.begin(), outcome.given.end(), [](const Given& g) { return g.is_by_stamps; }));
}

TEST_CASE("cameras that expose at different times are no stereo pair, with or without a wire that should join them") {
    for (const bool has_trigger : {false, true}) {
        for (const int skew_ms : {-10, 0, 1, 10, 15}) {
            CAPTURE(has_trigger, skew_ms);
            World world;
            world.trigger = false;
            world.right_delay_ns = skew_ms * kMs;
            SynchroniserOptions options;
            options.has_trigger = has_trigger;
            options.trigger_silence = {250 * kMs};
            Synchroniser sync(options);
            const Outcome outcome = run(world, sync);
            const bool together = std::abs(skew_ms) <= 1;
            CHECK(std::abs(sync.skew().ns - skew_ms * kMs) < kMs);
            CHECK(reported(outcome, SyncFault::kUnsynchronised) == !together);
            CHECK(views(outcome, 20, 200, true, true) == (together ? 180 : 0));
            CHECK(views(outcome, 20, 200, true, false) == (together ? 0 : 180));
            for (const SyncReport& r : outcome.reports) {
                CHECK((r.fault != SyncFault::kUnsynchronised || std::abs(r.value - skew_ms * kMs) < 3 * kMs));
            }
            CHECK(outcome.released == outcome.frames);
        }
    }
}

}  // namespace
}  // namespace facet::synchroniser_stamps_test
