// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/sync/synchroniser.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>
#include <string>

#include "tests/drivers/sync/sync_world.h"

namespace facet::synchroniser_test {
namespace {

using test::check_no_wrong_pair;
using test::g_slots;
using test::Given;
using test::kMs;
using test::kPeriodNs;
using test::kStartNs;
using test::midpoint;
using test::Outcome;
using test::reported;
using test::run;
using test::views;
using test::World;

TEST_CASE("a clean triggered rig: all pairs after the first votes, exact stamps, no heap, no reports") {
    World world;
    Synchroniser sync;
    const Outcome outcome = run(world, sync);
    CHECK(outcome.given.size() == 200 - 4);
    check_no_wrong_pair(outcome, 0);
    CHECK(outcome.allocations == 0);
    CHECK(sync.count(SyncFault::kDoubtful) == 8);  // four of each camera, before they are believed
    CHECK(outcome.reports.size() == 2);
    CHECK(outcome.given.back().right >= 0);
    CHECK(outcome.released == outcome.frames);
    // Nothing waits longer than its partner takes: arrival plus one inertial sample.
    for (const Given& g : outcome.given) {
        REQUIRE(g.at_ns - midpoint(g.left) < 30 * kMs);
    }
}

TEST_CASE("a stale frame in a camera's buffer does not shift the pairing") {
    for (const int stale : {1, 2, 3}) {
        World world;
        world.stale_left = stale;
        Synchroniser sync;
        const Outcome outcome = run(world, sync);
        check_no_wrong_pair(outcome, 0);
        CHECK(outcome.given.size() >= 195);
        World other;
        other.stale_right = stale;
        Synchroniser sync2;
        const Outcome outcome2 = run(other, sync2);
        check_no_wrong_pair(outcome2, 0);
        CHECK(outcome2.given.size() >= 195);
    }
}

TEST_CASE("an edge, or a frame, that vanishes without being counted shifts the count: found and corrected within 1 s") {
    World edge;
    edge.edge_vanished = {100};
    World left;
    left.left_vanished = {100};
    World right;
    right.right_vanished = {100};
    for (const World& world : {edge, left, right}) {
        Synchroniser sync;
        const Outcome outcome = run(world, sync);
        check_no_wrong_pair(outcome, 0);
        REQUIRE(reported(outcome, SyncFault::kPairingCorrected));
        for (const SyncReport& r : outcome.reports) {
            if (r.fault == SyncFault::kPairingCorrected) {
                CHECK(r.stamp.ns - midpoint(100) < 1'000 * kMs);
                CHECK(r.stamp.ns - midpoint(100) >= 0);
            }
        }
        // Pairs go on within half a second.
        const auto after = std::find_if(outcome.given.begin(), outcome.given.end(),
                                        [](const Given& g) { return g.left > 101 && g.right == g.left; });
        REQUIRE(after != outcome.given.end());
        CHECK(after->left <= 100 + 8);
        CHECK(outcome.released == outcome.frames);
    }
}

TEST_CASE("edges without numbers: a lost one is known by its time, and costs nothing") {
    World world;
    world.edges_numbered = false;
    world.edge_lost = {60, 100, 101, 102, 150};
    world.first_count = 0xFFFFFFF0U;  // the counts go round
    Synchroniser sync;
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 0);
    CHECK(outcome.given.size() == 200 - 4);
    CHECK(views(outcome, 0, 200, true, true) == 200 - 4);
    CHECK(sync.count(SyncFault::kPairingCorrected) == 0);
    CHECK(sync.count(SyncFault::kEdgeInterpolated) == 10);  // five of each camera
    CHECK(sync.count(SyncFault::kGap) == 3);
    CHECK(outcome.allocations == 0);
}

TEST_CASE("edges without numbers: pulses that were not made are taken for lost, found out and corrected") {
    World world;
    world.edges_numbered = false;
    for (int event = 100; event < 110; ++event) {  // nothing was triggered meanwhile
        world.edge_lost.insert(event);
        world.left_vanished.insert(event);
        world.right_vanished.insert(event);
    }
    Synchroniser sync;
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 0);
    CHECK(sync.count(SyncFault::kPairingCorrected) == 2);
    CHECK(views(outcome, 116, 200, true, true) == 200 - 116);
}

TEST_CASE("a line that bounces: edges too many cost frames, but none is given to them") {
    for (const bool numbered : {true, false}) {
        for (const int late_ms : {8, 20, 27, 33, 42}) {
            CAPTURE(numbered, late_ms);
            World world;
            world.edges_numbered = numbered;
            world.edge_twice = {100, 101, 102};
            world.second_edge_ns = late_ms * kMs;
            Synchroniser sync;
            const Outcome outcome = run(world, sync);
            check_no_wrong_pair(outcome, 0);
            CHECK(views(outcome, 0, 101, true, true) == 101 - 4);
            CHECK(views(outcome, 111, 200, true, true) == 200 - 111);
        }
    }
}

TEST_CASE("without a trigger the right camera is paired with the left one by count and time, stale frames too") {
    World world;
    world.trigger = false;
    world.stale_right = 1;
    world.right_lost = {50, 51};
    world.left_lost = {80};
    world.right_vanished = {120};
    world.right_delay_ns = 3 * kMs;
    SynchroniserOptions options;
    options.has_trigger = false;
    options.right_delay = {3 * kMs};
    Synchroniser sync(options);
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 3 * kMs);  // the cameras' own stamps
    CHECK(outcome.given.size() == 200);     // the lost left image's partner comes alone
    CHECK(reported(outcome, SyncFault::kMissingRight));
    CHECK(reported(outcome, SyncFault::kMissingLeft));
    CHECK(reported(outcome, SyncFault::kPairingCorrected));
    CHECK(outcome.released == outcome.frames);
}

TEST_CASE("a left camera that comes back and counts from zero costs the pairs it missed and one more") {
    for (const bool trigger : {true, false}) {
        CAPTURE(trigger);
        World world;
        world.trigger = trigger;
        for (int event = 60; event < 75; ++event) {
            world.left_vanished.insert(event);
        }
        world.left_restart = 75;
        SynchroniserOptions options;
        options.has_trigger = trigger;
        Synchroniser sync(options);
        const Outcome outcome = run(world, sync);
        check_no_wrong_pair(outcome, trigger ? 0 : 3 * kMs);
        CHECK(views(outcome, 0, 200, true, true) == 200 - 4 - 15 - 1);  // the first ones wait for votes
        const auto alone = std::count_if(outcome.given.begin(), outcome.given.end(),
                                         [](const Given& g) { return g.left >= 10 && g.right < 0; });
        CHECK(alone == 0);
        CHECK(sync.count(SyncFault::kPairingCorrected) == 0);
        CHECK(sync.count(SyncFault::kMissingLeft) == 16);
        CHECK(outcome.released == outcome.frames);
    }
}

TEST_CASE("lost frames are named and cost one view") {
    World world;
    world.left_lost = {50, 90, 91};
    world.right_lost = {60, 90};
    Synchroniser sync;
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 0);
    CHECK(outcome.given.size() == 196 - 1);  // both views of one event are lost
    CHECK(views(outcome, 0, 200, false, true) == 2);
    CHECK(views(outcome, 0, 200, true, false) == 1);
    CHECK(sync.count(SyncFault::kMissingRight) == 1);
    CHECK(sync.count(SyncFault::kMissingLeft) == 2);
    CHECK(sync.count(SyncFault::kGap) == 4);
    CHECK(sync.count(SyncFault::kPairingCorrected) == 0);
    CHECK(outcome.released == outcome.frames);
}

TEST_CASE("a lost edge is interpolated between its neighbours") {
    World world;
    world.edge_lost = {70, 100, 101};
    Synchroniser sync;
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 1);
    CHECK(outcome.given.size() == 196);
    CHECK(sync.count(SyncFault::kEdgeInterpolated) == 6);  // three edges, two cameras
    CHECK(reported(outcome, SyncFault::kEdgeInterpolated));
}

TEST_CASE("heavy jitter of stamps and arrivals, and random losses, never make a wrong pair") {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        std::mt19937 random(seed * 77);
        World world;
        world.events = 600;
        world.stamp_jitter_ms = 4.0;  // 25 ms is half a period: six sigma
        world.arrival_ms = 30.0;
        world.arrival_jitter_ms = 25.0;
        world.left_delay_ns = 12 * kMs;
        world.right_delay_ns = 7 * kMs;
        for (int event = 0; event < world.events; ++event) {
            for (std::set<int>* set : {&world.left_lost, &world.right_lost, &world.edge_lost}) {
                if (random() % 20 == 0) {
                    set->insert(event);
                }
            }
            for (std::set<int>* set : {&world.left_vanished, &world.right_vanished, &world.edge_vanished}) {
                if (random() % 200 == 0) {
                    set->insert(event);
                }
            }
        }
        SynchroniserOptions options;
        options.left_delay = {12 * kMs};
        options.right_delay = {7 * kMs};
        Synchroniser sync(options);
        const Outcome outcome = run(world, sync, seed);
        INFO("seed " << seed);
        check_no_wrong_pair(outcome, 1);
        CHECK(outcome.given.size() > 350);
        // Frames whose edge would come after the end still wait.
        CHECK(outcome.frames - outcome.released <= 2 * static_cast<int>(Synchroniser::kPending));
    }
}

TEST_CASE("frames wait for inertial samples; in a long silence the newest ones are kept") {
    World world;
    world.imu = [](std::int64_t t) { return t < midpoint(100) || t > midpoint(106) + 10 * kMs; };
    Synchroniser sync;
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 0);
    CHECK(reported(outcome, SyncFault::kUncovered));
    CHECK(outcome.given.size() >= 196 - 4);
    CHECK(outcome.given.size() < 196);
    CHECK(std::any_of(outcome.given.begin(), outcome.given.end(), [](const Given& g) { return g.left == 106; }));
    CHECK(outcome.released == outcome.frames);
}

TEST_CASE("duplicates are refused by name") {
    World world;
    world.left_twice = {30, 31};
    Synchroniser sync;
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 0);
    CHECK(sync.count(SyncFault::kDuplicate) == 2);
    CHECK(outcome.given.size() == 196);
    CHECK(outcome.released == outcome.frames);
}

TEST_CASE("cameras that do not count are paired by time") {
    World world;
    world.sequence = false;
    world.left_vanished = {40};
    world.edge_vanished = {60};
    SynchroniserOptions options;
    options.use_sequence = false;
    Synchroniser sync(options);
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 0);
    CHECK(outcome.given.size() == 199);
    CHECK(views(outcome, 0, 200, false, true) == 1);
    CHECK(reported(outcome, SyncFault::kGap));
}

TEST_CASE("another epoch, wrong order and a dead trigger are named") {
    Synchroniser sync;
    sync.add_imu({kStartNs});
    const std::size_t lent_before = g_slots.lent();
    const auto add_left = [&](std::int64_t stamp_ns, std::uint32_t sequence) {
        return sync.add_left({{stamp_ns}, sequence, {}, g_slots.take(), {}});
    };
    const std::int64_t other_epoch_ns = 1'700'000'000'000'000'000;
    CHECK(add_left(other_epoch_ns, 0) == Status::kInvalidArgument);
    CHECK(g_slots.lent() == lent_before);
    CHECK(sync.add_edge({{5}, 1, true}) == Status::kInvalidArgument);
    CHECK(sync.count(SyncFault::kEpochMismatch) == 2);
    SyncReport report;
    REQUIRE(sync.pop_report(report) == Status::kOk);
    CHECK(report.fault == SyncFault::kEpochMismatch);
    CHECK(report.camera == SyncCamera::kLeft);
    CHECK(std::string(to_string(report.fault)) == "clocks have different epochs");
    CHECK(add_left(other_epoch_ns, 0) == Status::kInvalidArgument);
    REQUIRE(sync.pop_report(report) == Status::kOk);      // of the edge
    CHECK(sync.pop_report(report) == Status::kNotReady);  // the same again is counted, not reported

    CHECK(add_left(kStartNs, 1) == Status::kOk);
    CHECK(add_left(kStartNs - 1, 2) == Status::kOutOfOrder);
    CHECK(sync.count(SyncFault::kOutOfOrder) == 1);
    for (int i = 1; i < 15; ++i) {
        CHECK(add_left(kStartNs + i * kPeriodNs, static_cast<std::uint32_t>(2 + i)) == Status::kOk);
        CHECK(g_slots.lent() - lent_before <= Synchroniser::kPending);
    }
    CHECK(sync.count(SyncFault::kTriggerSilent) > 0);
}

}  // namespace
}  // namespace facet::synchroniser_test
