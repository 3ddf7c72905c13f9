// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/axis_map.h"

#include <catch2/catch.hpp>

namespace facet::axis_map_test {
namespace {

TEST_CASE("an axis map says which sensor axis each body axis is") {
    AxisMap map;
    CHECK(map.apply({1, 2, 3}) == Eigen::Vector3d(1, 2, 3));
    REQUIRE(ok(map.parse("y -x z")));
    CHECK(map.apply({1, 2, 3}) == Eigen::Vector3d(2, -1, 3));
    REQUIRE(ok(map.parse("+x,-y,-z")));
    CHECK(map.apply({1, 2, 3}) == Eigen::Vector3d(1, -2, -3));
}

TEST_CASE("what is no rotation is refused, and the map stays as it was") {
    AxisMap map;
    REQUIRE(ok(map.parse("z x y")));
    for (const char* bad : {"", "x y", "x y -z", "x x z", "x y z x", "--x y z", "x y - z", "a b c", "x y z-"}) {
        INFO(bad);
        CHECK(map.parse(bad) == Status::kInvalidArgument);
    }
    CHECK(map.apply({1, 2, 3}) == Eigen::Vector3d(3, 1, 2));
}

}  // namespace
}  // namespace facet::axis_map_test
