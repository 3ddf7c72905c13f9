// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/plane_raster.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// A cell of a line is covered afterwards if at least `least` of those within `reach` of it were.
void resize_line(std::uint8_t* line, int count, std::ptrdiff_t stride, int reach, int least,
                 std::vector<std::uint8_t>& scratch) {
    scratch.resize(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        scratch[static_cast<std::size_t>(i)] = line[i * stride];
    }
    int sum = 0;
    for (int i = -reach; i < count; ++i) {
        sum += i + reach < count ? scratch[static_cast<std::size_t>(i + reach)] : 0;
        sum -= i - reach > 0 ? scratch[static_cast<std::size_t>(i - reach - 1)] : 0;
        if (i >= 0) {
            line[i * stride] = sum >= least ? 1 : 0;
        }
    }
}

}  // namespace

double signed_area(const PlaneRing& ring) {
    double twice = 0.0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        twice += cross(ring[i], ring[(i + 1) % ring.size()]);
    }
    return 0.5 * twice;
}

PlaneRaster::PlaneRaster(const Eigen::AlignedBox2d& box, double cell_m, double gap_m)
    : cell_m_(std::max({cell_m, std::sqrt(box.sizes().prod() / kMaxCells), box.sizes().maxCoeff() / kMaxSide})),
      reach_(static_cast<int>(std::lround(0.5 * gap_m / cell_m_))) {
    const int margin = reach_ + 1;  // nothing grows out of the grid
    width_ = static_cast<int>(std::ceil(box.sizes().x() / cell_m_)) + 2 * margin;
    height_ = static_cast<int>(std::ceil(box.sizes().y() / cell_m_)) + 2 * margin;
    origin_ = box.min() - Eigen::Vector2d::Constant(margin * cell_m_);
    cells_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
}

void PlaneRaster::cover(const PlaneTriangle& triangle) {
    std::array<Eigen::Vector2d, 3> p;  // in cells, counterclockwise, centres at whole numbers
    for (std::size_t k = 0; k < 3; ++k) {
        p[k] = ((triangle[k] - origin_) / cell_m_).array() - 0.5;
    }
    if (cross(p[1] - p[0], p[2] - p[0]) < 0.0) {
        std::swap(p[1], p[2]);
    }
    const Eigen::AlignedBox2d box = Eigen::AlignedBox2d(p[0]).extend(p[1]).extend(p[2]).intersection(
        Eigen::AlignedBox2d(Eigen::Vector2d::Zero(),
                            Eigen::Vector2d(static_cast<double>(width_ - 1), static_cast<double>(height_ - 1))));
    if (box.isEmpty()) {
        return;
    }
    for (int y = static_cast<int>(std::ceil(box.min().y())); y <= static_cast<int>(std::floor(box.max().y())); ++y) {
        for (int x = static_cast<int>(std::ceil(box.min().x())); x <= static_cast<int>(std::floor(box.max().x()));
             ++x) {
            const Eigen::Vector2d at(x, y);
            const bool is_inside = cross(p[1] - p[0], at - p[0]) >= 0.0 && cross(p[2] - p[1], at - p[1]) >= 0.0 &&
                                   cross(p[0] - p[2], at - p[2]) >= 0.0;
            cells_[index({x, y})] |= is_inside ? 1 : 0;
        }
    }
}

void PlaneRaster::resize_lines(int least) {
    std::vector<std::uint8_t> scratch;
    for (int y = 0; y < height_; ++y) {
        resize_line(&cells_[index({0, y})], width_, 1, reach_, least, scratch);
    }
    for (int x = 0; x < width_; ++x) {
        resize_line(&cells_[index({x, 0})], height_, width_, reach_, least, scratch);
    }
}

void PlaneRaster::close() {
    resize_lines(1);               // grows
    resize_lines(2 * reach_ + 1);  // shrinks
}

/// Cells that are connected by their sides have the same number, from 0; the others -1.
std::vector<int> PlaneRaster::label() const {
    std::vector<int> labels(cells_.size(), -1);
    std::vector<Cell> open;
    int next = 0;
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            if (!is_covered({x, y}) || labels[index({x, y})] >= 0) {
                continue;
            }
            labels[index({x, y})] = next;
            open.push_back({x, y});
            while (!open.empty()) {
                const Cell c = open.back();
                open.pop_back();
                for (const Cell& step : {Cell(1, 0), Cell(0, 1), Cell(-1, 0), Cell(0, -1)}) {
                    const Cell n = c + step;
                    if (is_covered(n) && labels[index(n)] < 0) {
                        labels[index(n)] = next;
                        open.push_back(n);
                    }
                }
            }
            ++next;
        }
    }
    return labels;
}

/// Follows the sides between covered and other cells, the covered ones on the left, from the lower side of `start`
/// until back there. Where two cells touch at a corner only, the line stays at its own.
PlaneRing PlaneRaster::trace(const Cell& start, std::vector<std::uint8_t>& is_traced) const {
    static const std::array<Cell, 4> kStep{Cell(1, 0), Cell(0, 1), Cell(-1, 0), Cell(0, -1)};
    static const std::array<Cell, 4> kLeft{Cell(0, 0), Cell(-1, 0), Cell(-1, -1), Cell(0, -1)};  // cell ahead
    static const std::array<Cell, 4> kRight{Cell(0, -1), Cell(0, 0), Cell(-1, 0), Cell(-1, -1)};
    PlaneRing ring;
    Cell at = start;
    std::size_t direction = 0;
    do {
        if (direction == 0) {
            is_traced[index(at)] = 1;
        }
        at += kStep[direction];
        const std::size_t before = direction;
        if (!is_covered(at + kLeft[direction])) {
            direction = (direction + 1) % 4;
        } else if (is_covered(at + kRight[direction])) {
            direction = (direction + 3) % 4;
        }
        if (direction != before) {
            ring.push_back(corner(at));
        }
    } while (at != start || direction != 0);
    return ring;
}

std::vector<CellOutline> PlaneRaster::outlines() const {
    const std::vector<int> labels = label();
    std::vector<CellOutline> outlines;
    std::vector<std::uint8_t> is_traced(cells_.size(), 0);  // the lower side of a cell
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            const Cell c(x, y);
            if (!is_covered(c) || is_covered(c - Cell(0, 1)) || is_traced[index(c)] != 0) {
                continue;
            }
            const auto of = static_cast<std::size_t>(labels[index(c)]);
            outlines.resize(std::max(outlines.size(), of + 1));
            PlaneRing ring = trace(c, is_traced);
            if (signed_area(ring) > 0.0) {
                outlines[of].boundary = std::move(ring);
            } else {
                outlines[of].holes.push_back(std::move(ring));
            }
        }
    }
    return outlines;
}

}  // namespace facet
