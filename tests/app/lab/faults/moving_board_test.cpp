// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/moving_board.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "app/lab/sim/default_rig.h"

namespace facet::moving_board_test {
namespace {

constexpr std::uint8_t kBackground = 5;  // no texture is as dark

GreyImage blank(const CameraModel& camera) {
    const CameraIntrinsics& k = camera.intrinsics();
    return {.width = k.width,
            .height = k.height,
            .pixels = std::vector<std::uint8_t>(static_cast<std::size_t>(k.width * k.height), kBackground)};
}

double covered_share(const GreyImage& image) {
    std::size_t count = 0;
    for (const std::uint8_t p : image.pixels) {
        count += p != kBackground ? 1 : 0;
    }
    return static_cast<double>(count) / static_cast<double>(image.pixels.size());
}

/// Grey value at a pixel that need not be whole.
double sample(const GreyImage& image, const Eigen::Vector2d& uv) {
    const int u = static_cast<int>(std::floor(uv.x()));
    const int v = static_cast<int>(std::floor(uv.y()));
    const double a = uv.x() - u;
    const double b = uv.y() - v;
    const ImageView view = image.view();
    return (1.0 - b) * ((1.0 - a) * view.at(u, v) + a * view.at(u + 1, v)) +
           b * ((1.0 - a) * view.at(u, v + 1) + a * view.at(u + 1, v + 1));
}

TEST_CASE("the board covers its share of the left image and nothing else") {
    const StereoRig rig = sim::euroc_rig();
    for (const double share : {0.1, 0.6}) {
        const MovingBoard board(rig, share);
        GreyImage image = blank(rig.left);
        board.draw(false, 0.0, image);
        CHECK(covered_share(image) == Approx(share).epsilon(0.3));  // the lens bends its edges
        CHECK(image.pixels.front() == kBackground);
        CHECK(image.view().at(image.width / 2, image.height / 2) != kBackground);
    }
}

TEST_CASE("both cameras see a point of the board where it is, before and after it has slid") {
    const StereoRig rig = sim::euroc_rig();
    const MovingBoard board(rig, 0.6);
    GreyImage left = blank(rig.left);
    GreyImage right = blank(rig.right);
    GreyImage later = blank(rig.left);
    board.draw(false, 0.0, left);
    board.draw(true, 0.0, right);
    board.draw(false, 0.05, later);
    double stereo = 0.0;
    double slid = 0.0;
    double other = 0.0;
    int count = 0;
    for (double x = -0.4; x < 0.4; x += 0.013) {
        for (double y = -0.3; y < 0.3; y += 0.017) {
            const Eigen::Vector3d p_C0(x, y, MovingBoard::kDistance_m);
            Eigen::Vector2d in_left;
            Eigen::Vector2d in_right;
            Eigen::Vector2d moved;
            REQUIRE(ok(rig.left.project(p_C0, in_left)));
            REQUIRE(ok(rig.right.project(rig.T_C1_C0() * p_C0, in_right)));
            REQUIRE(ok(rig.left.project(p_C0 + Eigen::Vector3d(0.05, 0.0, 0.0), moved)));
            stereo += std::abs(sample(left, in_left) - sample(right, in_right));
            slid += std::abs(sample(left, in_left) - sample(later, moved));
            other += std::abs(sample(left, in_left) - sample(later, in_left));
            ++count;
        }
    }
    CHECK(stereo / count < 4.0);
    CHECK(slid / count < 4.0);
    CHECK(other / count > 15.0);
}

TEST_CASE("an image of another size stays") {
    const MovingBoard board(sim::euroc_rig(), 0.6);
    GreyImage image{.width = 4, .height = 2, .pixels = std::vector<std::uint8_t>(8, kBackground)};
    board.draw(false, 0.0, image);
    CHECK(covered_share(image) == 0.0);
}

}  // namespace
}  // namespace facet::moving_board_test
