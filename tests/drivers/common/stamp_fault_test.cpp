// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/stamp_fault.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>

#include "tests/support/scripted_source.h"

namespace facet::stamp_fault_test {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST_CASE("stamps of the future and of long ago are refused, each by its own clock") {
    const ManualClock clock({1'000 * kSecond}, Duration{1'700'000'000 * kSecond});
    const auto fault = [&](std::int64_t age_ns, ClockDomain domain) {
        const ClockPair now = clock.read_pair();
        const Timestamp base = domain == ClockDomain::kRealtime ? now.realtime : now.monotonic;
        const char* words = stamp_fault(base - Duration{age_ns}, clock, domain);
        return std::string(words == nullptr ? "" : words);
    };
    for (const ClockDomain domain : {ClockDomain::kMonotonic, ClockDomain::kRealtime}) {
        CAPTURE(to_string(domain));
        CHECK(fault(0, domain).empty());
        CHECK(fault(-1'000'000, domain).empty());  // the noise of reading two clocks
        CHECK(fault(-1'000'001, domain) == "stamps in the future");
        CHECK(fault(-3'600 * kSecond, domain) == "stamps in the future");
        CHECK(fault(10 * kSecond, domain).empty());
        CHECK(fault(10 * kSecond + 1, domain) == "stamps of long ago");
        CHECK(fault(140'000'000 * kSecond, domain) == "stamps of long ago");
    }
    // Of the clocks of devices nothing is known.
    CHECK(fault(-3'600 * kSecond, ClockDomain::kHardware).empty());
    CHECK(fault(3'600 * kSecond, ClockDomain::kDevice).empty());
}

TEST_CASE("the most extreme stamps are refused as any other") {
    const ManualClock clock({1'000 * kSecond});
    using Limits = std::numeric_limits<std::int64_t>;
    CHECK(std::string(stamp_fault({Limits::max()}, clock, ClockDomain::kMonotonic)) == "stamps in the future");
    CHECK(std::string(stamp_fault({Limits::min()}, clock, ClockDomain::kMonotonic)) == "stamps of long ago");
}

}  // namespace
}  // namespace facet::stamp_fault_test
