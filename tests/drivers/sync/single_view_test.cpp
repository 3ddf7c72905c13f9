// SPDX-License-Identifier: BSD-2-Clause
// One camera of two silent, one camera only, and counts that wrap.
#include <catch2/catch.hpp>

#include "drivers/sync/synchroniser.h"
#include "tests/drivers/sync/sync_world.h"

namespace facet::single_view_test {
namespace {

using test::check_no_wrong_pair;
using test::Given;
using test::kMs;
using test::midpoint;
using test::Outcome;
using test::run;
using test::views;
using test::World;

TEST_CASE("a camera that falls silent leaves the other one's images, soon without a wait; then pairs again") {
    for (const bool trigger : {true, false}) {
        for (const bool left : {true, false}) {
            CAPTURE(trigger, left);
            World world;
            world.trigger = trigger;
            for (int event = 60; event < 120; ++event) {
                (left ? world.left_lost : world.right_lost).insert(event);
            }
            SynchroniserOptions options;
            options.has_trigger = trigger;
            Synchroniser sync(options);
            const Outcome outcome = run(world, sync);
            check_no_wrong_pair(outcome, trigger ? 0 : 3 * kMs);
            // Without a trigger, four images of the right camera wait for the left one; the others go.
            const long lost = left && !trigger ? 8 : 0;
            CHECK(views(outcome, 60, 120, !left, left) >= 60 - lost);
            CHECK(views(outcome, 72, 119, !left, left) == 47);
            CHECK(views(outcome, 121, 200, true, true) == 79);
            CHECK(outcome.allocations == 0);
            CHECK(outcome.released == outcome.frames);
            for (const Given& g : outcome.given) {
                REQUIRE((g.event() < 75 || g.at_ns - midpoint(g.event()) < 30 * kMs));
            }
            CHECK(sync.count(left ? SyncFault::kMissingLeft : SyncFault::kMissingRight) >= 59);
        }
    }
}

TEST_CASE("a camera that has never given an image does not keep the other one's back") {
    for (const bool trigger : {true, false}) {
        for (const bool left : {true, false}) {
            CAPTURE(trigger, left);
            World world;
            world.trigger = trigger;
            for (int event = 0; event < world.events; ++event) {
                (left ? world.left_vanished : world.right_vanished).insert(event);
            }
            SynchroniserOptions options;
            options.has_trigger = trigger;
            Synchroniser sync(options);
            const Outcome outcome = run(world, sync);
            check_no_wrong_pair(outcome, trigger ? 0 : 3 * kMs);
            CHECK(views(outcome, 15, 200, !left, left) == 185);
            CHECK(outcome.released == outcome.frames);
        }
    }
}

TEST_CASE("one camera alone waits for no other and misses none") {
    World world;
    world.trigger = false;
    for (int event = 0; event < world.events; ++event) {
        world.right_vanished.insert(event);
    }
    SynchroniserOptions options;
    options.has_trigger = false;
    options.has_right = false;
    Synchroniser sync(options);
    const Outcome outcome = run(world, sync);
    CHECK(outcome.given.size() == 200);
    CHECK(outcome.reports.empty());
    for (const Given& g : outcome.given) {
        REQUIRE(g.at_ns - midpoint(g.left) < 30 * kMs);
    }
}

TEST_CASE("counts of frames and edges go on across the end of their 32 bits") {
    for (const bool trigger : {true, false}) {
        CAPTURE(trigger);
        World world;
        world.trigger = trigger;
        world.first_count = 0xffffffffU - 60U;
        world.left_lost = {58, 59, 62};  // counted, on both sides of the end
        world.right_lost = {61};
        world.edge_lost = {64};
        SynchroniserOptions options;
        options.has_trigger = trigger;
        Synchroniser sync(options);
        const Outcome outcome = run(world, sync);
        check_no_wrong_pair(outcome, trigger ? 1 : 3 * kMs);
        CHECK(outcome.given.size() >= 196);
        CHECK(sync.count(SyncFault::kPairingCorrected) == 0);
        CHECK(sync.count(SyncFault::kMissingLeft) == 3);
        CHECK(sync.count(SyncFault::kGap) == (trigger ? 4 : 3));
        CHECK(outcome.released == outcome.frames);
    }
}

}  // namespace
}  // namespace facet::single_view_test
