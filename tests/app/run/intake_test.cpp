// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/intake.h"

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace facet::intake_test {
namespace {

constexpr int kWidth = 8;
constexpr int kHeight = 4;

/// Counts what it is shown.
struct CountingTap final : SampleTap {
    int samples = 0;
    int edges = 0;
    int pairs = 0;
    bool halves_fit = true;
    void on_imu(const ImuSample&) override { ++samples; }
    void on_edge(const TriggerEdge&) override { ++edges; }
    void on_pair(const SyncedFrame& pair) override {
        ++pairs;
        halves_fit = halves_fit && pair.left.image.width == kWidth / 2 && pair.right.image.width == kWidth / 2 &&
                     pair.right.image.data == pair.left.image.data + kWidth / 2;
    }
};

struct Bench {
    Bench() {
        options.sync.period = Duration{50'000'000};
        options.sync.has_trigger = false;
        options.sync.votes = 1;
        options.side_by_side = true;
    }
    void push(int count) {
        for (int i = 0; i < count; ++i, ++frames) {
            const Timestamp stamp{1'000'000'000 + 50'000'000LL * frames};
            REQUIRE(ok(queues->left.push({stamp,
                                          static_cast<std::uint32_t>(frames),
                                          {pixels.data(), kWidth, kHeight, kWidth},
                                          slots.take(),
                                          {}})));
            REQUIRE(ok(queues->imu.push({stamp, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}})));
        }
    }
    IntakeOptions options;
    std::unique_ptr<RunQueues> queues = std::make_unique<RunQueues>();
    SlotLender<8> slots;
    std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(kWidth * kHeight);
    int frames = 0;
};

TEST_CASE("the tap sees every sample and the halves that fit together, without heap") {
    Bench bench;
    Intake intake(bench.options, *bench.queues);
    CountingTap tap;
    intake.show(&tap);
    int turns = 0;
    std::size_t samples = 0;
    for (int i = 0; i < 5; ++i) {
        bench.push(2);
        const test::AllocationGuard guard;
        samples += intake.take_edges();
        (void)intake.take_images([&] { ++turns; });
        samples += intake.take_inertial([&](const ImuSample& sample) { samples += sample.stamp.ns > 0 ? 0 : 1; });
        for (SyncedFrame pair; intake.pop(pair);) {
        }
        const std::uint64_t allocations = guard.allocations();
        CHECK(allocations == 0);
    }
    CHECK(samples == 10);
    CHECK(tap.samples == 10);
    CHECK(tap.edges == 0);
    CHECK(tap.pairs >= 8);
    CHECK(tap.pairs <= 10);
    CHECK(tap.halves_fit);
    CHECK(turns >= 10);
}

TEST_CASE("an intake without a tap empties its queues all the same, and publishes what was found") {
    Bench bench;
    Intake intake(bench.options, *bench.queues);
    SharedFindings findings{};
    bench.push(1);
    // The same stamps again: the synchroniser refuses them and counts.
    bench.frames = 0;
    bench.push(1);
    CHECK(intake.take_images([] {}));
    CHECK_FALSE(intake.take_images([] {}));
    CHECK(intake.take_inertial([](const ImuSample&) {}) == 2);
    for (SyncedFrame pair; intake.pop(pair);) {
    }
    intake.publish(findings);
    std::uint64_t found = 0;
    for (const auto& count : findings) {
        found += count;
    }
    CHECK(found > 0);
}

}  // namespace
}  // namespace facet::intake_test
