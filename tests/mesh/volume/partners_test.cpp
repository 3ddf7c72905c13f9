// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/partners.h"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/mesh/depth/stereo_scene.h"

namespace facet::partners_test {
namespace {

/// A camera that flies along x, all of them looking along z.
std::vector<Se3> row_of(int count, double apart_m) {
    std::vector<Se3> row;
    for (int i = 1; i <= count; ++i) {
        row.push_back({Eigen::Quaterniond::Identity(), {apart_m * i, 0.0, 0.0}});
    }
    return row;
}

std::vector<std::size_t> chosen_of(const std::vector<Se3>& row, double depth_m) {
    const auto chosen = choose_partners(row, depth_m);
    return {chosen.begin(), chosen.end()};
}

TEST_CASE("each partner is twice as far away as the one before, none too near or too far") {
    CHECK(chosen_of(row_of(40, 0.05), 2.5) ==
          std::vector<std::size_t>{2, 6, 14});  // 0.15, 0.35, 0.75 m of 0.125 to 1.25
    CHECK(choose_partners(row_of(2, 0.06), 2.5).empty());
    CHECK(choose_partners(row_of(40, 0.05), 0.0).empty());
}

TEST_CASE("a view that looks elsewhere is no partner") {
    auto row = row_of(5, 0.2);
    row[0].q = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()));
    CHECK(chosen_of(row, 2.5) == std::vector<std::size_t>{1, 4});
}

/// By how much a point's match moves in another image if it lies at `far` in place of `near`, beside the camera's axis.
double step_px(const Se3& T_own_other, double near, double far) {
    return test::scene_rig().left.focal_px() * T_own_other.p.norm() * (1.0 / near - 1.0 / far);
}

TEST_CASE("a step of one pixel in stereo is several between partners, though nearer ones come first") {
    const double near = 2.3;
    const double far = 2.55;
    const Se3 T_left_right{Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0}};
    REQUIRE(step_px(T_left_right, near, far) < 1.1);
    const auto row = row_of(20, 0.05);
    const auto chosen = choose_partners(row, far);
    REQUIRE(!chosen.empty());
    CHECK(step_px(row[chosen.front()], near, far) < 3.0);
    CHECK(step_px(row[chosen.back()], near, far) > 6.0);
}

}  // namespace
}  // namespace facet::partners_test
