// SPDX-License-Identifier: BSD-2-Clause
// Which cells of a plane its faces cover, and the outlines of what is connected.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace facet {

/// A triangle in the axes of a plane (m).
using PlaneTriangle = std::array<Eigen::Vector2d, 3>;

/// A closed line in the axes of a plane (m); the last point is connected to the first.
using PlaneRing = std::vector<Eigen::Vector2d>;

/// The outline of cells that are connected by their sides, and of the holes in them.
struct CellOutline {
    PlaneRing boundary;            ///< counterclockwise
    std::vector<PlaneRing> holes;  ///< clockwise
};

/// A grid of square cells over a part of a plane. Faces seen again and again overlap in layers, and differ by
/// millimetres from one sighting to the next, so that their exact union costs much and is full of cracks; cells cost
/// their number, whatever the layers. Heap; reentrant.
class PlaneRaster {
public:
    /// Cells of `cell_m`, or as much larger as keeps their number within kMaxCells and kMaxSide, and a margin.
    /// @param box    finite, not empty
    /// @param gap_m  what close() closes
    PlaneRaster(const Eigen::AlignedBox2d& box, double cell_m, double gap_m);

    /// Covers the cells whose centre is inside the triangle or on its sides.
    void cover(const PlaneTriangle& triangle);

    /// Closes gaps narrower than gap_m: what is covered grows by half of it on each side, then shrinks likewise.
    void close();

    /// What is covered, as outlines along the sides of cells.
    std::vector<CellOutline> outlines() const;

    double cell_m() const { return cell_m_; }

private:
    static constexpr double kMaxCells = 4e6;  // without the margin: some 30 MB while outlines are sought
    static constexpr double kMaxSide = 2e4;
    using Cell = Eigen::Vector2i;

    bool is_covered(const Cell& c) const {
        return c.x() >= 0 && c.y() >= 0 && c.x() < width_ && c.y() < height_ && cells_[index(c)] != 0;
    }
    std::size_t index(const Cell& c) const {
        return static_cast<std::size_t>(c.y()) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(c.x());
    }
    Eigen::Vector2d corner(const Cell& c) const { return origin_ + cell_m_ * c.cast<double>(); }
    void resize_lines(int least);
    std::vector<int> label() const;
    PlaneRing trace(const Cell& start, std::vector<std::uint8_t>& is_traced) const;

    double cell_m_;
    int reach_;  ///< of closing (cells)
    Eigen::Vector2d origin_;
    int width_;
    int height_;
    std::vector<std::uint8_t> cells_;  ///< by row
};

/// Area within a ring (m^2): positive counterclockwise.
double signed_area(const PlaneRing& ring);

}  // namespace facet
