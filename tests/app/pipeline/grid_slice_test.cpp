// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/grid_slice.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "app/view/flight_viewer.h"
#include "tests/mesh/grid_watcher.h"

namespace facet::grid_slice_test {
namespace {

TEST_CASE("a slice of the grid has a wall, the space before it, and knows nothing of what is behind") {
    test::GridWatcher watcher;
    const Se3 eye = test::looking_along_x({0.03, 0.03, 0.03});
    for (int second = 0; second < 4; ++second) {
        watcher.see(test::wall_at(3.05), eye, 10.0 + 0.25 * second);
    }
    ViewGrid slice;
    slice_at(eye.p, *watcher.grid, slice);
    CHECK(slice.width == OccupancyGrid::kGridX);
    CHECK(slice.height == OccupancyGrid::kGridY);
    CHECK(slice.cells.size() == FlightViewer::kMaxCells);
    CHECK(slice.cell_m == Approx(watcher.grid->cell_m()));
    CHECK(slice.corner_W.z() == eye.p.z());
    const auto at = [&](double x, double y) {
        const auto column = std::lround(std::floor((x - slice.corner_W.x()) / slice.cell_m));
        const auto row = std::lround(std::floor((y - slice.corner_W.y()) / slice.cell_m));
        return int{slice.cells.at(static_cast<std::size_t>(row * slice.width + column))};
    };
    CHECK(at(3.05, 0.05) == 100);
    CHECK(at(3.05, 0.65) == 100);
    CHECK(at(1.55, 0.05) == 0);
    CHECK(at(4.55, 0.05) == -1);
    CHECK(at(-1.55, 0.05) == -1);
    slice_at(eye.p + Eigen::Vector3d(0.0, 0.0, 2.5), *watcher.grid, slice);  // above the wall
    CHECK(std::ranges::all_of(slice.cells, [](std::int8_t cell) { return cell == -1; }));
}

}  // namespace
}  // namespace facet::grid_slice_test
