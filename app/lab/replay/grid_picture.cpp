// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/grid_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/support/input_error.h"
#include "app/support/png_writer.h"

namespace facet {

/// A plane of the grid and its place in the picture.
struct GridPicture::Section {
    int right = 0;  ///< axis of the grid to the right, and upwards
    int up = 0;
    int column = 0;  ///< of its top left corner (px)
    int row = 0;
};

namespace {

constexpr std::array kCells{OccupancyGrid::kGridX, OccupancyGrid::kGridY, OccupancyGrid::kGridZ};
constexpr int kCross = 6;  // px to every side

std::uint8_t grey_of(const OccupancyGrid& grid, const Eigen::Vector3d& p_W) {
    switch (grid.at(p_W).space) {
        case Space::kFree: return GridPicture::kFree;
        case Space::kUnknown: return GridPicture::kUnknown;
        case Space::kOccupied: break;
    }
    return grid.has_surface(p_W) ? GridPicture::kSurface : GridPicture::kOccupied;
}

}  // namespace

GridPicture::GridPicture(const OccupancyGrid& grid, const Eigen::Vector3d& p_W)
    : pixels_(static_cast<std::size_t>(kWidth) * kHeight, kFree) {
    constexpr int kBeside = kPixels * OccupancyGrid::kGridX + kGap;
    constexpr int kBelow = kPixels * OccupancyGrid::kGridY + kGap;
    draw(grid, p_W, {.right = 0, .up = 1});
    draw(grid, p_W, {.right = 0, .up = 2, .row = kBelow});
    draw(grid, p_W, {.right = 2, .up = 1, .column = kBeside});
}

void GridPicture::draw(const OccupancyGrid& grid, const Eigen::Vector3d& p_W, const Section& section) {
    const double side = grid.cell_m() / kPixels;
    const Eigen::Vector3d low = grid.cell_m() * grid.lowest_cell().cast<double>();
    const int width = kPixels * kCells[static_cast<std::size_t>(section.right)];
    const int height = kPixels * kCells[static_cast<std::size_t>(section.up)];
    const int u_here = static_cast<int>(std::floor((p_W[section.right] - low[section.right]) / side));
    const int v_here = static_cast<int>(std::floor((p_W[section.up] - low[section.up]) / side));
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
            Eigen::Vector3d p = p_W;
            p[section.right] = low[section.right] + (u + 0.5) * side;
            p[section.up] = low[section.up] + (v + 0.5) * side;
            const int du = std::abs(u - u_here);
            const int dv = std::abs(v - v_here);
            const bool is_cross = std::min(du, dv) == 0 && std::max(du, dv) <= kCross;
            const int row = section.row + height - 1 - v;
            pixels_[static_cast<std::size_t>(row * kWidth + section.column + u)] =
                is_cross ? kSurface : grey_of(grid, p);
        }
    }
}

void write_grid_picture(const OccupancyGrid& grid, const Eigen::Vector3d& p_W, const std::string& path) {
    if (!ok(write_png(path, GridPicture(grid, p_W).view()))) {
        throw InputError(path + ": cannot be written");
    }
}

}  // namespace facet
