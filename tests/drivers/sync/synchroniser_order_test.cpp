// SPDX-License-Identifier: BSD-2-Clause
// Pairings that are off by whole frames, which time alone cannot see.
#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/drivers/sync/sync_world.h"

namespace facet::synchroniser_order_test {
namespace {

using test::check_no_wrong_pair;
using test::Given;
using test::kMs;
using test::kPeriodNs;
using test::Outcome;
using test::reported;
using test::run;
using test::World;

SynchroniserOptions own_pulses() {
    SynchroniserOptions options;
    options.first_is_first = true;
    return options;
}

TEST_CASE("where all edges are known from the first on, the first frame needs no votes") {
    World world;
    Synchroniser sync(own_pulses());
    const Outcome outcome = run(world, sync);
    CHECK(outcome.given.size() == 200);
    check_no_wrong_pair(outcome, 0);
    CHECK(outcome.reports.empty());
    CHECK(outcome.allocations == 0);
}

TEST_CASE("frames from before the first edge are not its frames") {
    for (const int stale : {1, 3}) {
        World world;
        world.stale_left = stale;
        Synchroniser sync(own_pulses());
        const Outcome outcome = run(world, sync);
        check_no_wrong_pair(outcome, 0);
        CHECK(outcome.given.size() >= 195);
    }
}

TEST_CASE("a camera that lets the first pulses pass is reported, and time decides") {
    World world;
    world.left_vanished = {0, 1};  // not even counted
    Synchroniser sync(own_pulses());
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 0);
    REQUIRE(reported(outcome, SyncFault::kOrderDoubtful));
    for (const SyncReport& report : outcome.reports) {
        if (report.fault == SyncFault::kOrderDoubtful) {
            CHECK(report.camera == SyncCamera::kLeft);
            CHECK(report.value == 2);
        }
    }
}

TEST_CASE("cameras that stamp their frames a whole period late are off by one frame, unless that is known") {
    World world;
    world.left_delay_ns = world.right_delay_ns = kPeriodNs;
    Synchroniser unaware;
    const Outcome wrong = run(world, unaware);
    REQUIRE(wrong.given.size() > 150);
    for (const Given& g : wrong.given) {
        REQUIRE(g.stamp_error_ns == kPeriodNs);  // and nothing says so
    }
    CHECK_FALSE(reported(wrong, SyncFault::kOrderDoubtful));
    Synchroniser warned(own_pulses());
    CHECK(reported(run(world, warned), SyncFault::kOrderDoubtful));
    SynchroniserOptions known = own_pulses();
    known.left_delay.ns = known.right_delay.ns = kPeriodNs;
    Synchroniser aware(known);
    const Outcome right = run(world, aware);
    CHECK(right.given.size() == 200);
    check_no_wrong_pair(right, 0);
    CHECK(right.reports.empty());
}

TEST_CASE("an estimated offset of about half a period is reported once, and again after it has been small") {
    Synchroniser sync;
    const Duration sigma = Duration::from_seconds(0.001);
    SyncReport report;
    sync.add_offset({1}, Duration{15 * kMs}, sigma);
    CHECK(sync.pop_report(report) == Status::kNotReady);
    sync.add_offset({2}, Duration{-24 * kMs}, Duration::from_seconds(0.02));  // nobody knows
    CHECK(sync.pop_report(report) == Status::kNotReady);
    for (int i = 0; i < 3; ++i) {
        sync.add_offset({3}, Duration{-24 * kMs}, sigma);
    }
    REQUIRE(ok(sync.pop_report(report)));
    CHECK(report.fault == SyncFault::kLargeOffset);
    CHECK(report.value == -24 * kMs);
    CHECK(sync.pop_report(report) == Status::kNotReady);
    CHECK(sync.count(SyncFault::kLargeOffset) == 3);
    sync.add_offset({4}, {}, sigma);
    sync.add_offset({5}, Duration{30 * kMs}, sigma);
    CHECK(ok(sync.pop_report(report)));
}

}  // namespace
}  // namespace facet::synchroniser_order_test
