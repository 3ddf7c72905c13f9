// SPDX-License-Identifier: BSD-2-Clause
// Holes of a mesh on true planes, by rasters.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "app/lab/eval/mesh_accuracy.h"

namespace facet {
namespace {

constexpr double kLeastCovered = 0.5;  // m^2: smaller patches say nothing about a wall
constexpr double kOnPlane = 0.03;      // m: true surface that belongs to the plane
constexpr double kFar = 1e3;           // m: any view counts
constexpr double kSamePlane = 0.02;    // m, and as sine of the angle between normals

/// Cells of a plane: 0 uncovered, 1 covered, 2 uncovered and open to the outside.
class Raster {
public:
    Raster(const EvalPlane& plane, double cell, double gap)
        : plane_(plane),
          cell_(cell),
          reach_(static_cast<int>(0.5 * gap / cell)),
          u_(plane.normal.unitOrthogonal()),
          v_(plane.normal.cross(u_)) {}

    using Flat = std::array<Eigen::Vector2d, 3>;

    Eigen::Vector2d flat(const Eigen::Vector3d& p) const { return {u_.dot(p) / cell_, v_.dot(p) / cell_}; }

    void cover(const std::vector<Flat>& triangles) {
        Eigen::Vector2d low(1e300, 1e300);
        Eigen::Vector2d high = -low;
        for (const Flat& t : triangles) {
            for (const Eigen::Vector2d& p : t) {
                low = low.cwiseMin(p);
                high = high.cwiseMax(p);
            }
        }
        const int border = 2 * reach_ + 1;  // room for the square to go round
        low_ = low.array().floor() - static_cast<double>(border);
        width_ = static_cast<int>(high.x() - low_.x()) + border + 2;
        height_ = static_cast<int>(high.y() - low_.y()) + border + 2;
        cells_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
        for (const Flat& t : triangles) {
            draw(t);
        }
    }

    /// Marks the uncovered cells that a square, of half width reach_, reaches from the border without touching covered
    /// ones: the square's middle moves over cells that are far enough from covered ones, and marks all under it.
    void flood() {
        const std::vector<char> blocked = dilated([this](std::size_t i) { return cells_[i] == 1; });
        std::vector<char> passed(cells_.size(), 0);
        std::vector<int> front{0};
        passed[0] = 1;
        while (!front.empty()) {
            const int at = front.back();
            front.pop_back();
            const int x = at % width_;
            const int y = at / width_;
            const std::array<std::pair<int, int>, 4> around{{{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}}};
            for (const auto& [nx, ny] : around) {
                const auto next = index(nx, ny);
                if (nx >= 0 && ny >= 0 && nx < width_ && ny < height_ && blocked[next] == 0 && passed[next] == 0) {
                    passed[next] = 1;
                    front.push_back(static_cast<int>(next));
                }
            }
        }
        const std::vector<char> open = dilated([&](std::size_t i) { return passed[i] == 1; });
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            cells_[i] = open[i] != 0 && cells_[i] == 0 ? char{2} : cells_[i];
        }
    }

    /// Calls visit(point) for the middle of every cell with this mark.
    template <class Visit>
    void for_each(char mark, Visit visit) const {
        for (int y = 0; y < height_; ++y) {
            for (int x = 0; x < width_; ++x) {
                if (cells_[index(x, y)] == mark) {
                    const Eigen::Vector2d c = cell_ * (low_ + Eigen::Vector2d(x + 0.5, y + 0.5));
                    visit(c.x() * u_ + c.y() * v_ + plane_.distance * plane_.normal);
                }
            }
        }
    }

private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    char& at_cell(int x, int y) { return cells_[index(x, y)]; }

    /// Cells within reach_, in both directions, of one for which is_set(index) holds.
    template <class IsSet>
    std::vector<char> dilated(IsSet is_set) const {
        std::vector<char> rows(cells_.size(), 0);
        for (int y = 0; y < height_; ++y) {
            for (int x = 0; x < width_; ++x) {
                if (is_set(index(x, y))) {
                    const auto first = rows.begin() + static_cast<std::ptrdiff_t>(index(std::max(0, x - reach_), y));
                    std::fill(
                        first,
                        rows.begin() + static_cast<std::ptrdiff_t>(index(std::min(width_ - 1, x + reach_), y)) + 1,
                        char{1});
                }
            }
        }
        std::vector<char> both(cells_.size(), 0);
        for (int y = 0; y < height_; ++y) {
            for (int near = std::max(0, y - reach_); near <= std::min(height_ - 1, y + reach_); ++near) {
                for (int x = 0; x < width_; ++x) {
                    both[index(x, y)] = static_cast<char>(both[index(x, y)] | rows[index(x, near)]);
                }
            }
        }
        return both;
    }

    void draw(const Flat& t) {
        const Eigen::Vector2d low = t[0].cwiseMin(t[1]).cwiseMin(t[2]) - low_;
        const Eigen::Vector2d high = t[0].cwiseMax(t[1]).cwiseMax(t[2]) - low_;
        const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
            return a.x() * b.y() - a.y() * b.x();
        };
        const double turn = cross(t[1] - t[0], t[2] - t[0]) < 0.0 ? -1.0 : 1.0;
        for (int y = static_cast<int>(low.y()); y <= static_cast<int>(high.y()); ++y) {
            for (int x = static_cast<int>(low.x()); x <= static_cast<int>(high.x()); ++x) {
                const Eigen::Vector2d p = low_ + Eigen::Vector2d(x + 0.5, y + 0.5);
                bool inside = true;
                for (std::size_t k = 0; k < 3; ++k) {
                    inside = inside && turn * cross(t[(k + 1) % 3] - t[k], p - t[k]) >= 0.0;
                }
                at_cell(x, y) = inside ? char{1} : at_cell(x, y);
            }
        }
    }

    const EvalPlane& plane_;
    double cell_;
    int reach_;
    Eigen::Vector3d u_;
    Eigen::Vector3d v_;
    Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
    int width_ = 0;
    int height_ = 0;
    std::vector<char> cells_;
};

std::vector<Raster::Flat> faces_on(const EvalPlane& plane, const TriangleSoup& mesh, const Raster& raster,
                                   const MeshEvalOptions& options, double& area) {
    const double least_cosine = std::cos(options.wall_angle_deg * std::numbers::pi / 180.0);
    std::vector<Raster::Flat> flat;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        bool is_on = std::abs(mesh.normal(i).dot(plane.normal)) > least_cosine;
        for (int k = 0; k < 3; ++k) {
            is_on = is_on && std::abs(plane.normal.dot(mesh.corner(i, k)) - plane.distance) < options.wall_distance_m;
        }
        if (is_on) {
            flat.push_back(
                {raster.flat(mesh.corner(i, 0)), raster.flat(mesh.corner(i, 1)), raster.flat(mesh.corner(i, 2))});
            area += mesh.area(i);
        }
    }
    return flat;
}

bool coincide(const EvalPlane& a, const EvalPlane& b) {
    const double side = a.normal.dot(b.normal) < 0.0 ? -1.0 : 1.0;
    return a.normal.cross(b.normal).norm() < kSamePlane && std::abs(a.distance - side * b.distance) < kSamePlane;
}

}  // namespace

FlatHoles find_flat_holes(const TriangleSoup& mesh, const SceneTruth& truth, const TriangleTree& truth_tree,
                          const MeshEvalOptions& options) {
    FlatHoles holes;
    const double cell_m2 = options.wall_cell_m * options.wall_cell_m;
    for (auto at = truth.planes.begin(); at != truth.planes.end(); ++at) {
        const EvalPlane& plane = *at;
        if (std::any_of(truth.planes.begin(), at, [&](const EvalPlane& other) { return coincide(other, plane); })) {
            continue;
        }
        Raster raster(plane, options.wall_cell_m, options.wall_gap_m);
        double area = 0.0;
        const std::vector<Raster::Flat> faces = faces_on(plane, mesh, raster, options, area);
        if (area < kLeastCovered) {
            continue;
        }
        raster.cover(faces);
        raster.flood();
        ++holes.planes;
        raster.for_each(1, [&](const Eigen::Vector3d&) { holes.covered_m2 += cell_m2; });
        raster.for_each(0, [&](const Eigen::Vector3d& p) {
            const TriangleTree::Nearest nearest = truth_tree.nearest(p, kOnPlane);
            if (nearest.triangle >= 0 && was_seen(truth, truth_tree, nearest.point, kFar)) {
                holes.hole_m2 += cell_m2;
            }
        });
    }
    return holes;
}

}  // namespace facet
