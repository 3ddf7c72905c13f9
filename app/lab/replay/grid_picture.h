// SPDX-License-Identifier: BSD-2-Clause
// A picture of the space around the vehicle, as the grid knows it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "mesh/occupancy_grid.h"
#include "platform/base/image_view.h"

namespace facet {

/// Three sections through a point, four pixels a cell, a pixel for each part of one: from above (x to the right, y up),
/// below it from the front (x to the right, z up), right of it from the side (z to the right, y up). White is free,
/// light grey unknown; in an occupied cell its surface is black, the rest dark grey. A cross marks the point.
class GridPicture {
public:
    static constexpr int kPixels = 4;  ///< of a cell along each axis
    static constexpr int kGap = 8;     ///< px between sections

    GridPicture(const OccupancyGrid& grid, const Eigen::Vector3d& p_W);
    ImageView view() const { return {pixels_.data(), kWidth, kHeight, kWidth}; }

    static constexpr std::uint8_t kFree = 255;
    static constexpr std::uint8_t kUnknown = 190;
    static constexpr std::uint8_t kOccupied = 110;
    static constexpr std::uint8_t kSurface = 0;
    static constexpr int kWidth = kPixels * (OccupancyGrid::kGridX + OccupancyGrid::kGridZ) + kGap;
    static constexpr int kHeight = kPixels * (OccupancyGrid::kGridY + OccupancyGrid::kGridZ) + kGap;

private:
    struct Section;
    void draw(const OccupancyGrid& grid, const Eigen::Vector3d& p_W, const Section& section);

    std::vector<std::uint8_t> pixels_;
};

/// Writes it as PNG. Throws InputError naming the path if it cannot be written.
void write_grid_picture(const OccupancyGrid& grid, const Eigen::Vector3d& p_W, const std::string& path);

}  // namespace facet
