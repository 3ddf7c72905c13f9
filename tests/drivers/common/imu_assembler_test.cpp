// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/imu_assembler.h"

#include <catch2/catch.hpp>

#include "tests/support/allocation_guard.h"

namespace facet::imu_assembler_test {
namespace {

const Eigen::Vector3d kZero = Eigen::Vector3d::Zero();

/// A linear motion, which interpolation must reproduce.
Eigen::Vector3d force_at(std::int64_t ns) { return Eigen::Vector3d(1.0, -2.0, 3.0) * static_cast<double>(ns) * 1e-9; }

TEST_CASE("two rates of different speed are put together without error on linear motion, and without heap") {
    const test::AllocationGuard guard;
    ImuAssembler assembler;
    std::int64_t rate_ns = 1'300'000;
    std::int64_t force_ns = 0;
    int given = 0;
    double worst = 0.0;
    Timestamp last;
    bool ordered = true;
    for (int i = 0; i < 4000; ++i) {
        // Whichever comes first; the force is delivered late by one.
        if (force_ns < rate_ns) {
            (void)assembler.add_force({force_ns}, force_at(force_ns));
            force_ns += 625'000;
        } else {
            (void)assembler.add_rate({rate_ns}, kZero);
            rate_ns += 2'500'000;
        }
        ImuSample sample;
        while (ok(assembler.pop(sample))) {
            worst = std::max(worst, (sample.a_B - force_at(sample.stamp.ns)).norm());
            ordered = ordered && sample.stamp > last;
            last = sample.stamp;
            ++given;
        }
    }
    const auto allocations = guard.allocations();
    CHECK(allocations == 0);
    CHECK(given >= 798);
    CHECK(worst < 1e-12);
    CHECK(ordered);
    CHECK(assembler.counters().unpaired == 0);
}

TEST_CASE("rates without forces on both sides, or across a gap, are dropped") {
    ImuAssembler assembler(Duration{10});
    ImuSample sample;
    (void)assembler.add_rate({5}, kZero);
    (void)assembler.add_force({6}, kZero);
    CHECK(assembler.pop(sample) == Status::kNotReady);
    CHECK(assembler.counters().unpaired == 1);
    (void)assembler.add_rate({8}, kZero);
    (void)assembler.add_force({17}, kZero);  // 11 after the one before
    CHECK(assembler.pop(sample) == Status::kNotReady);
    CHECK(assembler.counters().unpaired == 2);
    (void)assembler.add_rate({17}, kZero);  // exactly at a force: no neighbour needed
    CHECK(assembler.pop(sample) == Status::kOk);
    CHECK(assembler.add_rate({16}, kZero) == Status::kOutOfOrder);
    CHECK(assembler.add_force({17}, kZero) == Status::kOutOfOrder);
    CHECK(assembler.counters().out_of_order == 2);
}

TEST_CASE("samples keep their order when the clock is set back and everything that waits is forgotten") {
    ImuAssembler assembler;
    ImuSample sample;
    (void)assembler.add_rate({100}, kZero);
    (void)assembler.add_force({100}, kZero);
    REQUIRE(assembler.pop(sample) == Status::kOk);
    assembler.clear();
    for (const std::int64_t ns : {50, 100, 101}) {
        (void)assembler.add_rate({ns}, kZero);
        (void)assembler.add_force({ns}, kZero);
    }
    REQUIRE(assembler.pop(sample) == Status::kOk);
    CHECK(sample.stamp.ns == 101);
    CHECK(assembler.counters().out_of_order == 4);  // two of each
    CHECK(assembler.pop(sample) == Status::kNotReady);
}

TEST_CASE("a clock that may be set back takes the order with it after a few samples, and what waits is forgotten") {
    constexpr std::int64_t kHour = 3'600'000'000'000;
    for (const ClockDomain domain : {ClockDomain::kRealtime, ClockDomain::kHardware, ClockDomain::kMonotonic}) {
        CAPTURE(to_string(domain));
        ImuAssembler assembler(Duration{10}, domain);
        int given = 0;
        ImuSample sample;
        for (std::int64_t i = 0; i < 100; ++i) {
            const std::int64_t ns = i * 5 + (i < 50 ? kHour : 0);
            (void)assembler.add_force({ns - 1}, force_at(ns - 1));
            (void)assembler.add_rate({ns}, kZero);
            while (ok(assembler.pop(sample))) {
                ++given;
                CHECK((sample.a_B - force_at(sample.stamp.ns)).norm() < 1e-9);
            }
        }
        const bool followed = domain != ClockDomain::kMonotonic;
        CHECK(given >= (followed ? 90 : 48));
        CHECK((sample.stamp.ns < kHour) == followed);
    }
}

TEST_CASE("when forces stay away, the oldest rates are dropped and counted") {
    ImuAssembler assembler;
    for (int i = 0; i < 70; ++i) {
        (void)assembler.add_rate({i}, kZero);
    }
    CHECK(assembler.counters().overflowed == 70 - ImuAssembler::kCapacity);
    ImuSample sample;
    CHECK(assembler.pop(sample) == Status::kNotReady);
}

}  // namespace
}  // namespace facet::imu_assembler_test
