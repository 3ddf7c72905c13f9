// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/increasing_stamps.h"

#include <catch2/catch.hpp>

namespace facet {
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

}  // namespace
}  // namespace facet
