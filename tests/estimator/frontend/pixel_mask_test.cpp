// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/pixel_mask.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

namespace facet::pixel_mask_test {
namespace {

constexpr int kWide = 50;  // neither is a multiple of a block
constexpr int kHigh = 35;

PixelMask empty_mask() {
    PixelMask mask;
    mask.configure(kWide, kHigh);
    return mask;
}

bool covers(const PixelMask& mask, const Eigen::Vector2d& uv, Timestamp now) {
    std::vector<std::uint8_t> flags(static_cast<std::size_t>(kWide) * kHigh);
    mask.write(now, flags);
    const int u = std::clamp(static_cast<int>(std::lround(uv.x())), 0, kWide - 1);
    const int v = std::clamp(static_cast<int>(std::lround(uv.y())), 0, kHigh - 1);
    return flags[static_cast<std::size_t>(v) * kWide + static_cast<std::size_t>(u)] != 0;
}

TEST_CASE("a drawn mask covers exactly its black pixels", "[frontend]") {
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(kWide) * kHigh, 255);
    pixels[3 * kWide + 7] = 0;
    PixelMask mask = empty_mask();
    REQUIRE(ok(mask.draw({pixels.data(), kWide, kHigh, kWide})));
    CHECK(mask.is_drawn({7.0, 3.0}));
    CHECK(mask.is_drawn({7.4, 2.6}));
    CHECK_FALSE(mask.is_drawn({8.0, 3.0}));
    std::vector<std::uint8_t> flags(pixels.size(), 9);
    mask.write({}, flags);
    CHECK(std::count(flags.begin(), flags.end(), 1) == 1);
    CHECK(std::count(flags.begin(), flags.end(), 0) == kWide * kHigh - 1);
    CHECK(mask.draw({pixels.data(), kWide - 1, kHigh, kWide}) == Status::kInvalidArgument);
    CHECK(mask.is_drawn({7.0, 3.0}));
    REQUIRE(ok(mask.draw({})));
    CHECK_FALSE(mask.is_drawn({7.0, 3.0}));
}

TEST_CASE("what is found covers its surroundings, and only for a while", "[frontend]") {
    PixelMask mask = empty_mask();
    const Timestamp now{5'000'000'000};
    const Eigen::Vector2d uv(20.0, 17.0);
    CHECK(mask.found_share(now) == 0.0);
    mask.cover(uv, now);
    CHECK(covers(mask, uv, now));
    CHECK(covers(mask, uv + Eigen::Vector2d(-3.0, 3.0), now));
    CHECK_FALSE(covers(mask, uv + Eigen::Vector2d(17.0, 0.0), now));
    CHECK_FALSE(mask.is_drawn(uv));
    CHECK(mask.found_share(now) > 0.0);
    CHECK(mask.found_share(now) < 0.2);
    std::vector<std::uint8_t> flags(static_cast<std::size_t>(kWide) * kHigh);
    mask.write(now, flags);
    CHECK(flags[17 * kWide + 20] == 1);
    const Timestamp later = now + Duration::from_seconds(PixelMask::kMemory_s);
    CHECK_FALSE(covers(mask, uv, later));
    CHECK(mask.found_share(later) == 0.0);
    mask.write(later, flags);
    CHECK(std::count(flags.begin(), flags.end(), 1) == 0);
}

TEST_CASE("pixels at and beyond the border are the border's", "[frontend]") {
    PixelMask mask = empty_mask();
    const Timestamp now{1};
    mask.cover({kWide - 1.0, kHigh - 1.0}, now);
    CHECK(covers(mask, {kWide + 5.0, kHigh + 5.0}, now));
    mask.cover({-3.0, -3.0}, now);
    CHECK(covers(mask, {0.0, 0.0}, now));
}

}  // namespace
}  // namespace facet::pixel_mask_test
