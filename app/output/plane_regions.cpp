// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/plane_regions.h"

#include <algorithm>
#include <boost/polygon/polygon.hpp>
#include <cmath>

namespace facet {
namespace {

using GridPoint = boost::polygon::point_data<int>;  // whole millimetres
using GridPolygon = boost::polygon::polygon_data<int>;
using GridRegion = boost::polygon::polygon_with_holes_data<int>;
using GridSet = boost::polygon::polygon_set_data<int>;

constexpr double kFar_m = 1e5;  // from the plane's origin: no surface is seen there
constexpr double kMmPerM = 1e3;

bool is_sound(const PlaneTriangle& t) {
    return std::ranges::all_of(
        t, [](const Eigen::Vector2d& p) { return p.allFinite() && p.cwiseAbs().maxCoeff() < kFar_m; });
}

double distance_to_side(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const Eigen::Vector2d side = b - a;
    const double t = side.squaredNorm() > 0.0 ? std::clamp(side.dot(p - a) / side.squaredNorm(), 0.0, 1.0) : 0.0;
    return (p - a - t * side).norm();
}

/// Fewer corners, none of the others farther than the tolerance from the line through these [Douglas and Peucker, The
/// Canadian Cartographer 1973].
PlaneRing simplified(const PlaneRing& ring, double tolerance_m) {
    std::vector<bool> is_kept(ring.size() + 1, false);  // the first corner once more at the end
    const auto at = [&](std::size_t i) { return ring[i % ring.size()]; };
    std::size_t farthest = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        farthest = (at(i) - at(0)).norm() > (at(farthest) - at(0)).norm() ? i : farthest;
    }
    is_kept[0] = is_kept[farthest] = true;
    std::vector<std::pair<std::size_t, std::size_t>> open{{0, farthest}, {farthest, ring.size()}};
    while (!open.empty()) {
        const auto [first, last] = open.back();
        open.pop_back();
        std::size_t worst = first;
        double worst_m = tolerance_m;
        for (std::size_t i = first + 1; i < last; ++i) {
            if (const double m = distance_to_side(at(i), at(first), at(last)); m > worst_m) {
                worst = i;
                worst_m = m;
            }
        }
        if (worst != first) {
            is_kept[worst] = true;
            open.emplace_back(first, worst);
            open.emplace_back(worst, last);
        }
    }
    PlaneRing kept;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        if (is_kept[i]) {
            kept.push_back(ring[i]);
        }
    }
    return kept;
}

GridPolygon to_grid(const PlaneRing& ring) {
    std::vector<GridPoint> points;
    for (const Eigen::Vector2d& p : ring) {
        points.emplace_back(static_cast<int>(std::lround(kMmPerM * p.x())),
                            static_cast<int>(std::lround(kMmPerM * p.y())));
    }
    return {points.begin(), points.end()};
}

template <class Points>
PlaneRing from_grid(const Points& points, bool is_counterclockwise) {
    PlaneRing ring;
    for (const GridPoint& p : points) {
        const Eigen::Vector2d at = Eigen::Vector2d(p.x(), p.y()) / kMmPerM;
        if (ring.empty() || (at != ring.back() && at != ring.front())) {
            ring.push_back(at);
        }
    }
    if ((signed_area(ring) > 0.0) != is_counterclockwise) {
        std::ranges::reverse(ring);
    }
    return ring;
}

/// Regions within lines that may touch or cross: they are cut apart where they do.
void add_regions(const GridSet& set, double min_area_m2, std::vector<PlaneRegion>& regions) {
    std::vector<GridRegion> parts;
    set.get(parts);
    for (const GridRegion& part : parts) {
        PlaneRegion region;
        region.boundary = from_grid(part, true);
        region.area_m2 = signed_area(region.boundary);
        for (auto hole = part.begin_holes(); hole != part.end_holes(); ++hole) {
            region.holes.push_back(from_grid(*hole, false));
            region.area_m2 += signed_area(region.holes.back());
        }
        if (region.area_m2 >= min_area_m2) {
            regions.push_back(std::move(region));
        }
    }
}

}  // namespace

PlaneAxes::PlaneAxes(const PlaneFit& fit, PlaneKind kind) {
    const Eigen::Vector3d n = fit.normal_W.normalized();
    const Eigen::Vector3d along = kind == PlaneKind::kHorizontal ? fit.along_W : Eigen::Vector3d::UnitZ().cross(n);
    const Eigen::Vector3d flat = along - n * n.dot(along);
    R_W_A.col(0) = flat.norm() > 1e-6 ? flat.normalized() : n.unitOrthogonal();
    R_W_A.col(1) = n.cross(R_W_A.col(0));
    R_W_A.col(2) = n;
    origin_W = fit.centroid_W - n * fit.residual(fit.centroid_W);
    for (int k = 0; k < 2; ++k) {
        sigma_turn[k] = std::hypot(R_W_A.col(k).dot(fit.along_W) * fit.sigma_along_rad,
                                   R_W_A.col(k).dot(fit.across_W) * fit.sigma_across_rad);
    }
}

std::vector<PlaneRegion> find_plane_regions(std::span<const PlaneTriangle> triangles,
                                            const PlaneRegionOptions& options) {
    Eigen::AlignedBox2d box;
    for (const PlaneTriangle& t : triangles) {
        for (std::size_t k = 0; k < 3 && is_sound(t); ++k) {
            box.extend(t[k]);
        }
    }
    if (box.isEmpty()) {
        return {};
    }
    PlaneRaster raster(box, options.cell_m, options.gap_m);
    for (const PlaneTriangle& t : triangles) {
        if (is_sound(t)) {
            raster.cover(t);
        }
    }
    raster.close();
    const double tolerance_m = options.tolerance_m * raster.cell_m() / options.cell_m;
    std::vector<PlaneRegion> regions;
    for (const CellOutline& outline : raster.outlines()) {
        if (signed_area(outline.boundary) < options.min_area_m2) {
            continue;
        }
        GridSet set;
        set.insert(to_grid(simplified(outline.boundary, tolerance_m)));
        for (const PlaneRing& hole : outline.holes) {
            if (-signed_area(hole) >= options.min_area_m2) {
                set.insert(to_grid(simplified(hole, tolerance_m)), /*is_hole=*/true);
            }
        }
        add_regions(set, options.min_area_m2, regions);
    }
    std::ranges::stable_sort(regions, std::greater(), &PlaneRegion::area_m2);
    return regions;
}

std::vector<PlaneTriangle> triangulate(const PlaneRegion& region) {
    GridSet set;
    set.insert(to_grid(region.boundary));
    for (const PlaneRing& hole : region.holes) {
        set.insert(to_grid(hole), /*is_hole=*/true);
    }
    std::vector<GridPolygon> trapezoids;
    set.get_trapezoids(trapezoids);
    std::vector<PlaneTriangle> triangles;
    for (const GridPolygon& trapezoid : trapezoids) {
        const PlaneRing ring = from_grid(trapezoid, true);
        for (std::size_t i = 2; i < ring.size(); ++i) {
            triangles.push_back({ring[0], ring[i - 1], ring[i]});
        }
    }
    return triangles;
}

}  // namespace facet
