// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/free_matches.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/app/lab/check/shifted_pattern.h"

namespace facet::free_matches_test {
namespace {

using test::kPatternHeight;
using test::kPatternWidth;
using test::pattern;
using test::view;

void check_shift(const std::vector<PointPair>& pairs, std::size_t at_least, const Eigen::Vector2d& shift) {
    CHECK(pairs.size() >= at_least);
    for (const PointPair& pair : pairs) {
        CHECK((pair.second - pair.first - shift).norm() < 0.1);
    }
}

TEST_CASE("stereo matches are found far away and off the row, without a calibration") {
    FreeMatcher matcher;
    REQUIRE(ok(matcher.configure(kPatternWidth, kPatternHeight)));
    const std::vector<std::uint8_t> left = pattern(0, 0);
    check_shift(matcher.match_stereo(view(left), view(pattern(41, -9))), 30, {-41.0, 9.0});
    CHECK(matcher.match_stereo(view(left), view(pattern(0, 0, 2))).size() < 5);
}

TEST_CASE("corners are followed from an anchor over several frames") {
    FreeMatcher matcher;
    REQUIRE(ok(matcher.configure(kPatternWidth, kPatternHeight)));
    CHECK(matcher.follow(view(pattern(0, 0)), true).empty());
    check_shift(matcher.follow(view(pattern(5, 3)), false), 50, {-5.0, -3.0});
    check_shift(matcher.follow(view(pattern(12, 5)), true), 50, {-12.0, -5.0});
    check_shift(matcher.follow(view(pattern(14, 5)), false), 50, {-2.0, 0.0});
}

TEST_CASE("the mean difference is in grey levels") {
    std::vector<std::uint8_t> image = pattern(0, 0);
    CHECK(mean_difference(view(image), view(image)) == 0.0);
    const std::vector<std::uint8_t> before = image;
    for (std::uint8_t& pixel : image) {
        pixel = static_cast<std::uint8_t>(pixel ^ 1U);
    }
    CHECK(mean_difference(view(before), view(image)) == Approx(1.0));
}

TEST_CASE("images that are too small are refused") {
    FreeMatcher matcher;
    CHECK(matcher.configure(60, 40) == Status::kInvalidArgument);
}

}  // namespace
}  // namespace facet::free_matches_test
