// SPDX-License-Identifier: BSD-2-Clause
// Time, ids and image views: the small values that everything else is made of.
#include <array>
#include <catch2/catch.hpp>
#include <type_traits>

#include "platform/base/image_view.h"
#include "platform/base/samples.h"
#include "platform/base/timestamp.h"
#include "platform/base/typed_id.h"

namespace facet::values_test {
namespace {

TEST_CASE("stamps of this century keep their nanoseconds", "[timestamp]") {
    const Timestamp a{1403636579763555584};
    const Timestamp b = a + Duration{5};
    CHECK((b - a).ns == 5);
    CHECK(b > a);
    CHECK((b - Duration{5}) == a);
    CHECK((-(b - a)).ns == -5);
}

TEST_CASE("seconds round to the nearest nanosecond, both ways", "[timestamp]") {
    CHECK(Duration::from_seconds(0.005).ns == 5000000);
    CHECK(Duration::from_seconds(-0.005).ns == -5000000);
    CHECK(Duration::from_seconds(1e-10).ns == 0);
    CHECK(Duration::from_seconds(-0.6e-9).ns == -1);
    CHECK(Duration{1500000000}.seconds() == Approx(1.5));
}

TEST_CASE("ids of two kinds do not mix, and start invalid", "[typed_id]") {
    STATIC_REQUIRE_FALSE(std::is_convertible_v<PlaneId, LandmarkId>);
    STATIC_REQUIRE_FALSE(std::is_convertible_v<int, LandmarkId>);
    CHECK_FALSE(LandmarkId{}.valid());
    CHECK(LandmarkId{0}.valid());
    CHECK(LandmarkId{1} < LandmarkId{2});
}

TEST_CASE("an image view walks rows by its stride", "[image_view]") {
    std::array<std::uint8_t, 12> pixels{};
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        pixels[i] = static_cast<std::uint8_t>(i);
    }
    const ImageView view{.data = pixels.data(), .width = 3, .height = 3, .stride = 4};
    CHECK(view.at(0, 0) == 0);
    CHECK(view.at(2, 0) == 2);
    CHECK(view.at(1, 2) == 9);
    CHECK_FALSE(view.empty());
    CHECK(StereoFrame{}.right.empty());
}

}  // namespace
}  // namespace facet::values_test
