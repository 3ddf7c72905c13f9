// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/grid_picture.h"

#include <catch2/catch.hpp>
#include <memory>

namespace facet::grid_picture_test {
namespace {

TEST_CASE("sections show what the grid says of their points") {
    // GIVEN points on a wall ahead, 2.06 m along x, seen by two keyframes
    const auto grid = std::make_unique<OccupancyGrid>();
    const auto view = std::make_unique<KeyframeView>();
    const HorizonMesh nothing;
    const Eigen::Vector3d eye(0.03, 0.03, 0.03);
    view->T_W_C0.p = eye;
    std::vector<DepthPoint> points;
    for (int i = -5; i <= 5; ++i) {
        for (int j = -5; j <= 5; ++j) {
            points.push_back({{2.06, 0.1 * i + 0.03, 0.1 * j + 0.03}, 0.01});
        }
    }
    for (int k = 1; k <= 2; ++k) {
        view->stamp = {1'000'000'000LL * k};
        grid->update(*view, nothing, static_cast<std::uint32_t>(k));
        grid->add_depth({points.data(), points.size()});
    }
    // WHEN the sections through the vehicle are drawn
    const GridPicture picture(*grid, eye);
    const ImageView image = picture.view();
    // THEN in plan the vehicle is in the middle, free space leads to the wall, the rest of whose cell is dark
    const int side = GridPicture::kPixels;
    const int u_here = side * OccupancyGrid::kGridX / 2 + 1;
    const int v_here = side * OccupancyGrid::kGridY / 2 - 2;
    CHECK(image.at(u_here, v_here) == GridPicture::kSurface);  // the cross
    CHECK(image.at(u_here + 10 * side, v_here) == GridPicture::kFree);
    CHECK(image.at(side * (OccupancyGrid::kGridX / 2 + 20) + 2, v_here) == GridPicture::kSurface);
    CHECK(image.at(side * (OccupancyGrid::kGridX / 2 + 20), v_here) == GridPicture::kOccupied);
    CHECK(image.at(u_here - 20 * side, v_here) == GridPicture::kUnknown);
    CHECK(image.at(u_here + 25 * side, v_here) == GridPicture::kUnknown);
    // THEN from the side the same wall, seen from within its plane, is not in the section through the vehicle
    const int z_here = side * OccupancyGrid::kGridX + GridPicture::kGap + side * OccupancyGrid::kGridZ / 2 + 1;
    CHECK(image.at(z_here, v_here) == GridPicture::kSurface);
    CHECK(image.at(z_here + 20 * side, v_here) == GridPicture::kUnknown);
    // THEN from the front it stands at its place, half a metre up at least
    const int below = side * OccupancyGrid::kGridY + GridPicture::kGap + side * OccupancyGrid::kGridZ / 2 - 2;
    CHECK(image.at(side * (OccupancyGrid::kGridX / 2 + 20) + 2, below - 4 * side) == GridPicture::kSurface);
    CHECK(image.at(side * (OccupancyGrid::kGridX / 2 + 20) + 2, below - 12 * side) == GridPicture::kUnknown);
}

}  // namespace
}  // namespace facet::grid_picture_test
