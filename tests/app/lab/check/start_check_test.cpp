// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/start_check.h"

#include <catch2/catch.hpp>
#include <utility>

#include "tests/app/lab/check/shifted_pattern.h"

namespace facet::start_check_test {
namespace {

/// Two equal cameras side by side, the right one 0.1 m to the right: in front of the wall, points lie farther left in
/// its images.
StereoRig side_by_side() {
    CameraIntrinsics k;
    k.width = test::kPatternWidth;
    k.height = test::kPatternHeight;
    k.fx = k.fy = 230.0;
    k.cx = 0.5 * k.width;
    k.cy = 0.5 * k.height;
    StereoRig rig;
    rig.left = rig.right = CameraModel(k);
    rig.T_B_C1.p.x() = 0.1;
    return rig;
}

/// What is said of 20 frames of a wall at 1.15 m whose images are moved by so many pixels.
std::vector<CheckVerdict> said_of(const StereoRig& rig, int left_px, int right_px) {
    const std::vector<std::uint8_t> left = test::pattern(left_px, 0);
    const std::vector<std::uint8_t> right = test::pattern(right_px, 0);
    StartCheck check(rig);
    std::vector<CheckVerdict> all;
    for (int k = 0; k < 20; ++k) {
        for (CheckVerdict& verdict : check.add({.stamp = {k}, .left = test::view(left), .right = test::view(right)})) {
            all.push_back(std::move(verdict));
        }
    }
    return all;
}

TEST_CASE("a log that begins as its calibration says is not spoken of") {
    CHECK(said_of(side_by_side(), 0, 20).empty());
}

TEST_CASE("exchanged images, exchanged calibrations and one camera recorded twice are reported once, at the start") {
    const auto images = said_of(side_by_side(), 20, 0);
    REQUIRE(images.size() == 1);
    CHECK(images[0].name == "camera order");
    StereoRig exchanged = side_by_side();
    std::swap(exchanged.T_B_C0, exchanged.T_B_C1);
    const auto calibrations = said_of(exchanged, 0, 20);
    REQUIRE(calibrations.size() == 1);
    CHECK(calibrations[0].name == "camera order");
    const auto twice = said_of(side_by_side(), 0, 0);
    REQUIRE_FALSE(twice.empty());
    CHECK(twice[0].sentence == "both cameras show the same image: one camera was recorded twice.");
}

TEST_CASE("images without a right one, or of two sizes, are not judged") {
    const std::vector<std::uint8_t> left = test::pattern(0, 0);
    StartCheck check(side_by_side());
    CHECK(check.add({.stamp = {}, .left = test::view(left), .right = {}}).empty());
    StereoRig uneven = side_by_side();
    CameraIntrinsics small = uneven.right.intrinsics();
    small.width = 200;
    uneven.right = CameraModel(small);
    CHECK(said_of(uneven, 0, 0).empty());
}

}  // namespace
}  // namespace facet::start_check_test
