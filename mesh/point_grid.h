// SPDX-License-Identifier: BSD-2-Clause
// Points of an image in cells, to test whether one is near a pixel.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "mesh/capacity.h"
#include "platform/base/fixed_vector.h"

namespace facet {

/// Up to kMaxMeshPoints points; one more is a contract violation. Points outside the image belong to the nearest cell
/// at the border. O(1) for evenly spread points. Thread-bound. No heap.
class PointGrid {
public:
    PointGrid() { clear(0.0, 1, 1); }

    /// Forgets all points. @param distance_px  distance that counts as near  @param width, height  of the image (px)
    void clear(double distance_px, int width, int height) {
        distance2_ = static_cast<float>(distance_px * distance_px);
        cell_px_ = std::max(static_cast<float>(distance_px), static_cast<float>(std::max(width, height)) / kCells);
        points_.clear();
        first_.fill(kNone);
    }

    void add(const Eigen::Vector2f& pixel) {
        std::int16_t& first = first_[cell(of(pixel.x()), of(pixel.y()))];
        next_[points_.size()] = first;
        first = static_cast<std::int16_t>(points_.size());
        points_.push_back(pixel);
    }

    /// Whether a point is nearer to the pixel than the distance.
    bool has_near(const Eigen::Vector2f& pixel) const {
        const int u = of(pixel.x());
        const int v = of(pixel.y());
        for (int y = std::max(0, v - 1); y <= std::min(kCells - 1, v + 1); ++y) {
            for (int x = std::max(0, u - 1); x <= std::min(kCells - 1, u + 1); ++x) {
                for (std::int16_t p = first_[cell(x, y)]; p != kNone; p = next_[static_cast<std::size_t>(p)]) {
                    if ((points_[static_cast<std::size_t>(p)] - pixel).squaredNorm() < distance2_) {
                        return true;
                    }
                }
            }
        }
        return false;
    }

private:
    static constexpr int kCells = 64;  ///< a side
    static constexpr std::int16_t kNone = -1;

    int of(float coordinate) const {
        return static_cast<int>(std::clamp(coordinate / cell_px_, 0.0F, static_cast<float>(kCells - 1)));
    }
    static std::size_t cell(int x, int y) { return static_cast<std::size_t>(y * kCells + x); }

    float distance2_ = 0.0F;
    float cell_px_ = 1.0F;
    FixedVector<Eigen::Vector2f, kMaxMeshPoints> points_;
    std::array<std::int16_t, kMaxMeshPoints> next_{};
    std::array<std::int16_t, static_cast<std::size_t>(kCells) * kCells> first_{};
};

}  // namespace facet
