// SPDX-License-Identifier: BSD-2-Clause
// Cameras, a trigger and an IMU with all that can happen on their way to the synchroniser, for its tests.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "drivers/sync/synchroniser.h"
#include "tests/support/allocation_guard.h"

namespace facet::test {

inline constexpr std::int64_t kMs = 1'000'000;
inline constexpr std::int64_t kPeriodNs = 50 * kMs;
inline constexpr std::int64_t kExposureNs = 4 * kMs;
inline constexpr std::int64_t kStartNs = 100'000 * kMs;

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
    std::set<int> edge_twice;                     ///< a second edge later, that triggers nothing
    std::int64_t second_edge_ns = kPeriodNs / 2;
    std::set<int> left_twice;
    std::uint32_t first_count = 0;  ///< of cameras and edges
    int left_restart = -1;          ///< the left camera's count begins anew with this event
    std::function<bool(std::int64_t)> imu = [](std::int64_t) { return true; };
    std::function<std::int64_t(int)> left_stamp_error = [](int) { return 0; };
    bool trigger = true;
    bool edges_numbered = true;  ///< else lost edges are not counted either
    bool sequence = true;
};

struct Given {
    int left = -1;  ///< true events; -1: no image
    int right = -1;
    int event() const { return left >= 0 ? left : right; }
    std::int64_t stamp_error_ns = 0;
    std::int64_t at_ns = 0;  ///< when it came out
    bool is_by_stamps = false;
};

struct Outcome {
    std::vector<Given> given;
    std::vector<SyncReport> reports;
    std::uint64_t allocations = 0;
    int released = 0;
    int frames = 0;
};

inline std::int64_t midpoint(int event) { return kStartNs + event * kPeriodNs + kExposureNs / 2; }

/// The slots of both cameras. They outlive every synchroniser that may still hold some.
inline SlotLender<2048> g_slots;

/// Runs a world through a synchroniser, in order of arrival.
inline Outcome run(const World& world, Synchroniser& sync, unsigned seed = 1) {
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
        std::uint32_t sequence = world.first_count;
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
    std::uint32_t edge_sequence = world.first_count;
    for (int event = 0; event < world.events && world.trigger; ++event) {
        if (world.edge_vanished.contains(event)) {
            continue;
        }
        const bool is_lost = world.edge_lost.contains(event);
        edge_sequence += world.edges_numbered || !is_lost ? 1 : 0;
        const std::uint32_t own = edge_sequence;
        if (!is_lost) {
            const std::int64_t stamp = kStartNs + event * kPeriodNs;
            arrivals.push_back({stamp + kMs, Kind::kEdge, {{stamp}, own, true, world.edges_numbered}, {}});
        }
        if (world.edge_twice.contains(event)) {
            const std::int64_t stamp = kStartNs + event * kPeriodNs + world.second_edge_ns;
            arrivals.push_back({stamp + kMs, Kind::kEdge, {{stamp}, ++edge_sequence, true, world.edges_numbered}, {}});
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
        const AllocationGuard guard;
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
            const auto event_of = [&](const CameraFrame& f) {
                return f.slot.held() ? truth[static_cast<std::size_t>(f.slot.slot())] : -1;
            };
            Given g{event_of(frame.left), event_of(frame.right), 0, a.at_ns, frame.is_by_stamps};
            g.stamp_error_ns = frame.stamp.ns - midpoint(g.event());
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

inline bool reported(const Outcome& outcome, SyncFault fault) {
    return std::any_of(outcome.reports.begin(), outcome.reports.end(),
                       [&](const SyncReport& r) { return r.fault == fault; });
}

/// Every pair that came out is of one event, and its stamp is right.
inline void check_no_wrong_pair(const Outcome& outcome, std::int64_t tolerance_ns) {
    for (const Given& g : outcome.given) {
        INFO("event " << g.left << " with " << g.right << ", stamp off by " << g.stamp_error_ns);
        REQUIRE((g.right < 0 || g.left < 0 || g.right == g.left));
        REQUIRE(std::abs(g.stamp_error_ns) <= tolerance_ns);
    }
}

/// How many of the events in [from, to) came out with these views.
inline long views(const Outcome& outcome, int from, int to, bool left, bool right) {
    return std::count_if(outcome.given.begin(), outcome.given.end(), [&](const Given& g) {
        return g.event() >= from && g.event() < to && (g.left >= 0) == left && (g.right >= 0) == right;
    });
}

}  // namespace facet::test
