// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/linux_clock.h"

#include <catch2/catch.hpp>
#include <chrono>

namespace facet::linux_clock_test {
namespace {

TEST_CASE("the Linux clock is the steady clock, and its pairs are taken at one instant") {
    LinuxClock clock;
    const auto steady = [] {
        return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
            .count();
    };
    const std::int64_t before = steady();
    const Timestamp now = clock.now();
    const ClockPair pair = clock.read_pair();
    const std::int64_t system =
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
            .count();
    const std::int64_t after = steady();
    CHECK(before <= now.ns);
    CHECK(now.ns <= pair.monotonic.ns);
    CHECK(pair.monotonic.ns <= after);
    CHECK(pair.uncertainty.ns >= 0);
    CHECK(std::abs(system - pair.realtime.ns) < 5'000'000'000);
}

TEST_CASE("sleeping lasts at least as long as asked, and not at all for the past") {
    LinuxClock clock;
    const Timestamp before = clock.now();
    clock.sleep(Duration::from_seconds(0.005));
    CHECK(clock.now() - before >= Duration::from_seconds(0.005));
    clock.sleep_until({-1});
    clock.sleep_until(before);
}

}  // namespace
}  // namespace facet::linux_clock_test
