// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/grid_slice.h"

namespace facet {
namespace {

constexpr std::int8_t kFreeCell = 0;
constexpr std::int8_t kOccupiedCell = 100;
constexpr std::int8_t kUnknownCell = -1;

/// The worst state of a column's cells between two heights.
Space worst_between(double below_m, double above_m, const Eigen::Vector3d& p_W, const OccupancyGrid& grid) {
    return grid.box(p_W - Eigen::Vector3d(0.0, 0.0, below_m), p_W + Eigen::Vector3d(0.0, 0.0, above_m)).space;
}

}  // namespace

void slice_at(const Eigen::Vector3d& p_W, const OccupancyGrid& grid, ViewGrid& slice) {
    const GridSweepRequest band;
    const double cell_m = grid.cell_m();
    const Eigen::Vector3d low_W = cell_m * grid.lowest_cell().cast<double>();
    slice.cell_m = static_cast<float>(cell_m);
    slice.width = OccupancyGrid::kGridX;
    slice.height = OccupancyGrid::kGridY;
    slice.corner_W = {low_W.x(), low_W.y(), p_W.z()};
    slice.cells.clear();
    for (int y = 0; y < slice.height; ++y) {
        for (int x = 0; x < slice.width; ++x) {
            const Eigen::Vector3d at_W(low_W.x() + (x + 0.5) * cell_m, low_W.y() + (y + 0.5) * cell_m, p_W.z());
            if (worst_between(band.below_m, band.above_m, at_W, grid) == Space::kOccupied) {
                slice.cells.push_back(kOccupiedCell);
            } else {
                const bool is_free = worst_between(band.wedge_m, band.wedge_m, at_W, grid) == Space::kFree;
                slice.cells.push_back(is_free ? kFreeCell : kUnknownCell);
            }
        }
    }
}

}  // namespace facet
