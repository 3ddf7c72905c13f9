// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/increasing_stamps.h"

#include <catch2/catch.hpp>

namespace facet::increasing_stamps_test {
namespace {

TEST_CASE("samples whose stamps do not increase are refused and counted") {
    IncreasingStamps order;
    std::uint64_t refused = 0;
    CHECK(order.pass({-5}, refused));  // whatever the first stamp is
    CHECK_FALSE(order.pass({-5}, refused));
    CHECK(order.pass({7}, refused));
    CHECK_FALSE(order.pass({6}, refused));
    CHECK(refused == 2);
    CHECK(order.pass({8}, refused));
    CHECK(refused == 2);
}

TEST_CASE("a sample that is allowed but not delivered leaves the order as it was") {
    IncreasingStamps order;
    std::uint64_t refused = 0;
    REQUIRE(order.pass({10}, refused));
    CHECK(order.allows({20}, refused));
    CHECK(order.allows({15}, refused));
    order.delivered({15});
    CHECK_FALSE(order.allows({15}, refused));
    CHECK(refused == 1);
}

TEST_CASE("a clock that was set back is followed once enough samples increase; the monotonic clock never is") {
    for (const ClockDomain domain : {ClockDomain::kRealtime, ClockDomain::kHardware, ClockDomain::kMonotonic}) {
        CAPTURE(to_string(domain));
        IncreasingStamps order(domain);
        std::uint64_t refused = 0;
        REQUIRE(order.pass({1'000}, refused));
        // Samples that change places, or a clock that stands still, are no new beginning.
        for (const std::int64_t ns : {5, 6, 7, 8, 4, 4, 4, 4, 4, 4, 1'001, 5, 6, 7, 8}) {
            CHECK(order.pass({ns}, refused) == (ns > 1'000));
        }
        CHECK(refused == 14);
        const bool follows = domain != ClockDomain::kMonotonic;
        CHECK(order.pass({9}, refused) == follows);
        CHECK(order.pass({10}, refused) == follows);
        CHECK_FALSE(order.pass({10}, refused));
    }
}

}  // namespace
}  // namespace facet::increasing_stamps_test
