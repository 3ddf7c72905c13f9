// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/sync/synchroniser.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace facet {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kPeriodNs = 50 * kMs;
constexpr std::int64_t kExposureNs = 4 * kMs;
constexpr std::int64_t kStartNs = 100'000 * kMs;

/// What happens on the way from a trigger to the synchroniser, by event number.
struct World {
    int events = 200;
    double stamp_jitter_ms = 0.5;    ///< sigma of camera stamps
    double arrival_ms = 15.0;        ///< mean delay of frames' arrival
    double arrival_jitter_ms = 5.0;  ///< uniform, both sides
    std::int64_t left_delay_ns = 0;  ///< camera stamps lie this much after the midpoint
    std::int64_t right_delay_ns = 0;
    int stale_left = 0;  ///< frames in the left camera's buffer before the first trigger
    int stale_right = 0;
    std::set<int> left_lost, right_lost;          ///< counted by the camera
    std::set<int> left_vanished, right_vanished;  ///< not even counted
    std::set<int> edge_lost, edge_vanished;       ///< counted by the kernel, or not
    std::set<int> left_twice;
    int left_restart = -1;  ///< the left camera's count begins anew with this event
    std::function<bool(std::int64_t)> imu = [](std::int64_t) { return true; };
    std::function<std::int64_t(int)> left_stamp_error = [](int) { return 0; };
    bool trigger = true;
    bool sequence = true;
};

struct Given {
    int left = -1;  ///< true events
    int right = -1;
    std::int64_t stamp_error_ns = 0;
    std::int64_t at_ns = 0;  ///< when it came out
};

struct Outcome {
    std::vector<Given> given;
    std::vector<SyncReport> reports;
    std::uint64_t allocations = 0;
    int released = 0;
    int frames = 0;
};

std::int64_t midpoint(int event) { return kStartNs + event * kPeriodNs + kExposureNs / 2; }

/// The slots of both cameras. They outlive every synchroniser that may still hold some.
SlotLender<2048> g_slots;

/// Runs a world through a synchroniser, in order of arrival.
Outcome run(const World& world, Synchroniser& sync, unsigned seed = 1) {
    enum class Kind : std::uint8_t { kImu, kEdge, kLeft, kRight };
    struct Arrival {
        std::int64_t at_ns = 0;
        Kind kind = Kind::kImu;
        TriggerEdge edge;
        CameraFrame frame;
    };
    std::mt19937 random(seed);  // NOLINT(cert-msc51-cpp): fixed on purpose
    std::normal_distribution<double> jitter(0.0, world.stamp_jitter_ms * kMs);
    std::uniform_real_distribution<double> arrival(-world.arrival_jitter_ms * kMs, world.arrival_jitter_ms * kMs);
    std::vector<Arrival> arrivals;
    Outcome outcome;
    const std::size_t lent_before = g_slots.lent();
    std::vector<int> truth(decltype(g_slots)::capacity());  // by slot
    const auto add_camera = [&](Kind kind, int stale, const std::set<int>& lost, const std::set<int>& vanished,
                                std::int64_t delay_ns) {
        std::uint32_t sequence = 0;
        std::int64_t last_at = 0;
        for (int event = -stale; event < world.events; ++event) {
            if (vanished.contains(event)) {
                continue;
            }
            if (kind == Kind::kLeft && event == world.left_restart) {
                sequence = 0;
            }
            const std::uint32_t own = sequence++;
            if (lost.contains(event)) {
                continue;
            }
            Arrival a;
            a.kind = kind;
            a.frame.stamp.ns = midpoint(event) + delay_ns + static_cast<std::int64_t>(jitter(random)) +
                               (kind == Kind::kLeft ? world.left_stamp_error(event) : 0);
            // A camera's own stamps are in order.
            a.frame.sequence = world.sequence ? own : 0;
            a.frame.exposure.ns = kExposureNs;
            a.at_ns = std::max(last_at + 1,
                               midpoint(event) + static_cast<std::int64_t>(world.arrival_ms * kMs + arrival(random)));
            last_at = a.at_ns;
            const bool twice = kind == Kind::kLeft && world.left_twice.contains(event);
            for (int copy = 0; copy < (twice ? 2 : 1); ++copy) {
                SlotLease slot = g_slots.take();
                REQUIRE(slot.held());
                truth[static_cast<std::size_t>(slot.slot())] = event;
                ++outcome.frames;
                const CameraFrame& f = a.frame;
                arrivals.push_back({a.at_ns + copy, kind, {}, {f.stamp, f.sequence, {}, std::move(slot), f.exposure}});
            }
        }
    };
    add_camera(Kind::kLeft, world.stale_left, world.left_lost, world.left_vanished, world.left_delay_ns);
    add_camera(Kind::kRight, world.stale_right, world.right_lost, world.right_vanished, world.right_delay_ns);
    std::uint32_t edge_sequence = 0;
    for (int event = 0; event < world.events && world.trigger; ++event) {
        if (world.edge_vanished.contains(event)) {
            continue;
        }
        const std::uint32_t own = ++edge_sequence;
        if (!world.edge_lost.contains(event)) {
            const std::int64_t stamp = kStartNs + event * kPeriodNs;
            arrivals.push_back({stamp + kMs, Kind::kEdge, {{stamp}, own, true}, {}});
        }
    }
    for (std::int64_t t = kStartNs - 500 * kMs; t < midpoint(world.events) + 500 * kMs; t += 5 * kMs) {
        if (world.imu(t)) {
            arrivals.push_back({t + 2 * kMs, Kind::kImu, {{t}, 0, true}, {}});
        }
    }
    std::stable_sort(arrivals.begin(), arrivals.end(),
                     [](const Arrival& a, const Arrival& b) { return a.at_ns < b.at_ns; });

    outcome.given.reserve(truth.size());
    outcome.reports.reserve(1000);
    std::int64_t newest_imu_ns = 0;
    std::int64_t last_stamp_ns = 0;
    for (Arrival& a : arrivals) {
        const test::AllocationGuard guard;
        if (a.kind == Kind::kImu) {
            newest_imu_ns = a.edge.stamp.ns;
            sync.add_imu(a.edge.stamp);
        } else if (a.kind == Kind::kEdge) {
            (void)sync.add_edge(a.edge);
        } else {
            (void)(a.kind == Kind::kLeft ? sync.add_left(std::move(a.frame)) : sync.add_right(std::move(a.frame)));
        }
        SyncedFrame frame;
        while (ok(sync.pop(frame))) {
            Given g{truth[static_cast<std::size_t>(frame.left.slot.slot())], -1, 0, a.at_ns};
            g.right = frame.right.slot.held() ? truth[static_cast<std::size_t>(frame.right.slot.slot())] : -1;
            g.stamp_error_ns = frame.stamp.ns - midpoint(g.left);
            outcome.given.push_back(g);
            outcome.allocations += guard.allocations();
            REQUIRE(frame.stamp.ns <= newest_imu_ns);
            REQUIRE(frame.stamp.ns > last_stamp_ns);
            last_stamp_ns = frame.stamp.ns;
        }
        SyncReport report;
        while (ok(sync.pop_report(report))) {
            outcome.reports.push_back(report);
        }
    }
    outcome.released = outcome.frames - static_cast<int>(g_slots.lent() - lent_before);
    return outcome;
}

bool reported(const Outcome& outcome, SyncFault fault) {
    return std::any_of(outcome.reports.begin(), outcome.reports.end(),
                       [&](const SyncReport& r) { return r.fault == fault; });
}

/// Every pair that came out is of one event, and its stamp is right.
void check_no_wrong_pair(const Outcome& outcome, std::int64_t tolerance_ns) {
    for (const Given& g : outcome.given) {
        INFO("event " << g.left << " with " << g.right << ", stamp off by " << g.stamp_error_ns);
        REQUIRE((g.right < 0 || g.right == g.left));
        REQUIRE(std::abs(g.stamp_error_ns) <= tolerance_ns);
    }
}

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
    CHECK(outcome.given.size() == 199);
    CHECK(reported(outcome, SyncFault::kMissingRight));
    CHECK(reported(outcome, SyncFault::kMissingLeft));
    CHECK(reported(outcome, SyncFault::kPairingCorrected));
    CHECK(outcome.released == outcome.frames);
}

TEST_CASE("a left camera that comes back and counts from zero costs no pair beyond those it missed") {
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
        CHECK(outcome.given.size() == 200 - 15 - (trigger ? 4 : 0));
        const auto alone = std::count_if(outcome.given.begin(), outcome.given.end(),
                                         [](const Given& g) { return g.left >= 10 && g.right < 0; });
        CHECK(alone == 0);
        CHECK(sync.count(SyncFault::kPairingCorrected) == 0);
        CHECK(sync.count(SyncFault::kMissingLeft) == 15);
        CHECK(outcome.released == outcome.frames);
    }
}

TEST_CASE("lost frames are named and cost one view or one pair") {
    World world;
    world.left_lost = {50, 90, 91};
    world.right_lost = {60, 90};
    Synchroniser sync;
    const Outcome outcome = run(world, sync);
    check_no_wrong_pair(outcome, 0);
    CHECK(outcome.given.size() == 196 - 3);
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
    CHECK(outcome.given.size() == 198);
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
}  // namespace facet
