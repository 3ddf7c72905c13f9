// SPDX-License-Identifier: BSD-2-Clause
// The questions that a planner asks the grid.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/grid_walk.h"
#include "mesh/occupancy_grid.h"

namespace facet {
namespace {

constexpr double kSectorWidth = 2.0 * std::numbers::pi / kSweepSectors;

/// Distance from a point to a cube.
double distance_to_cube(const Eigen::Vector3d& p, const Eigen::Vector3d& centre, double side) {
    return ((p - centre).cwiseAbs().array() - 0.5 * side).max(0.0).matrix().norm();
}

}  // namespace

/// Takes over a worse state; of equal ones, the lesser certainty and the greater age.
void OccupancyGrid::worsen(const GridState& by, GridState& state) {
    if (by.space > state.space) {
        state = by;
    } else if (by.space == state.space) {
        state.certainty = std::min(state.certainty, by.certainty);
        state.age_s = std::max(state.age_s, by.age_s);
    }
}

GridRay OccupancyGrid::cast(const Eigen::Vector3d& p_W, const Eigen::Vector3d& direction, double max_range_m) const {
    GridRay ray;
    ray.end = {Space::kFree, 1.0F, 0.0F};
    ray.free_m = max_range_m;
    const Eigen::Vector3d d = direction.normalized();
    walk(config_.cell_m, p_W, d, max_range_m, [&](const Eigen::Vector3i& c, double distance) {
        const Cell cell = find(c);
        const Space space = space_of(cell);
        if (space == Space::kOccupied) {
            distance = surface_in(c, p_W, d, distance);
            if (distance > max_range_m) {
                return true;
            }
        }
        const bool is_free_so_far = ray.end.space == Space::kFree;
        if (is_free_so_far && space == Space::kFree) {
            worsen(describe(cell), ray.end);
        } else if (is_free_so_far) {
            ray.end = describe(cell);
            ray.free_m = distance;
        }
        ray.obstacle_m = space == Space::kOccupied ? distance : ray.obstacle_m;
        return space != Space::kOccupied && holds(c);
    });
    return ray;
}

/// Where a ray enters the first part of an occupied cell that holds a surface; infinite if it passes between them.
double OccupancyGrid::surface_in(const Eigen::Vector3i& c, const Eigen::Vector3d& from,
                                 const Eigen::Vector3d& direction, double entered) const {
    const std::uint64_t surface = surface_[index_of(c)];
    if (surface == 0) {
        return entered;
    }
    double found = std::numeric_limits<double>::infinity();
    walk(config_.cell_m / kParts, from + entered * direction, direction, std::numbers::sqrt3 * config_.cell_m,
         [&](const Eigen::Vector3i& part, double inside) {
             const bool is_surface = is_part_of(part, c) && (surface & part_bit(part)) != 0;
             found = is_surface ? entered + inside : found;
             return !is_surface;
         });
    return found;
}

/// Cells in shells of growing cubes, until no shell can hold a nearer one.
template <class IsIn>
GridNearest OccupancyGrid::search(const Eigen::Vector3d& p_W, double max_range_m, IsIn is_in) const {
    GridNearest nearest;
    const Eigen::Vector3i middle = cell_of(p_W);
    const int last = std::min(static_cast<int>(std::ceil(max_range_m / config_.cell_m)) + 1, kGridX);
    const auto offer = [&](const Eigen::Vector3i& c) {
        const Cell cell = find(c);
        const Space space = space_of(cell);
        if (space == Space::kFree) {
            return;
        }
        const Eigen::Vector3d centre = centre_of(c);
        const double distance = distance_to_cube(p_W, centre, config_.cell_m);
        double& least = space == Space::kOccupied ? nearest.obstacle_m : nearest.unknown_m;
        if (distance > max_range_m || distance >= least || !is_in(centre)) {
            return;
        }
        least = distance;
        if (space == Space::kOccupied) {
            nearest.obstacle_W = centre;
            nearest.obstacle = describe(cell);
        }
    };
    for (int r = 0; r <= last && (r - 1) * config_.cell_m <= nearest.obstacle_m; ++r) {
        for (int z = -r; z <= r; ++z) {
            for (int y = -r; y <= r; ++y) {
                // Within the shell's walls every cell, else only the two ends of the row.
                const int step = std::abs(z) == r || std::abs(y) == r ? 1 : std::max(1, 2 * r);
                for (int x = -r; x <= r; x += step) {
                    offer(middle + Eigen::Vector3i(x, y, z));
                }
            }
        }
    }
    return nearest;
}

GridNearest OccupancyGrid::nearest(const Eigen::Vector3d& p_W, double max_range_m) const {
    return search(p_W, max_range_m, [](const Eigen::Vector3d&) { return true; });
}

GridNearest OccupancyGrid::nearest_in_direction(const Eigen::Vector3d& p_W, const Eigen::Vector3d& direction,
                                                double half_angle_rad, double max_range_m) const {
    const Eigen::Vector3d axis = direction.normalized();
    const double cosine = std::cos(half_angle_rad);
    return search(p_W, max_range_m, [&](const Eigen::Vector3d& centre) {
        const Eigen::Vector3d d = centre - p_W;
        return axis.dot(d) >= cosine * d.norm();
    });
}

/// How far the wedge is free at an azimuth, horizontally.
/// @param worst  takes over certainty and age of what is passed
double OccupancyGrid::wedge_range(const GridSweepRequest& request, double azimuth_rad, GridState& worst) const {
    double range = request.max_range_m;
    for (const double height : {-request.wedge_m, 0.0, request.wedge_m}) {
        const Eigen::Vector3d direction(std::cos(azimuth_rad), std::sin(azimuth_rad), height / request.max_range_m);
        const double length = direction.norm();
        const GridRay ray = cast(request.p_W, direction, length * request.max_range_m);
        range = std::min(range, ray.free_m / length);
        worsen(ray.end, worst);
    }
    return range;
}

void OccupancyGrid::sweep(const GridSweepRequest& request, std::span<GridSector, kSweepSectors> sectors) const {
    std::fill(sectors.begin(), sectors.end(), GridSector{});
    const Eigen::Vector3d& p = request.p_W;
    const double range = request.max_range_m;
    const Eigen::Vector3i low = cell_of(p - Eigen::Vector3d(range, range, request.below_m)).cwiseMax(low_);
    const Eigen::Vector3i high = cell_of(p + Eigen::Vector3d(range, range, request.above_m))
                                     .cwiseMin(low_ + Eigen::Vector3i(kGridX - 1, kGridY - 1, kGridZ - 1));
    for (int z = low.z(); z <= high.z(); ++z) {
        for (int y = low.y(); y <= high.y(); ++y) {
            for (int x = low.x(); x <= high.x(); ++x) {
                const Eigen::Vector3i c(x, y, z);
                const Cell cell = cells_[index_of(c)];
                if (space_of(cell) != Space::kOccupied) {
                    continue;
                }
                const Eigen::Vector2d d = (centre_of(c) - p).head<2>();
                const auto distance = static_cast<float>(std::max(0.0, d.norm() - 0.5 * config_.cell_m));
                if (static_cast<double>(distance) > range) {
                    continue;
                }
                // All sectors that the cell's circle touches.
                const double middle = (std::atan2(d.y(), d.x()) - request.start_rad) / kSectorWidth;
                const double half =
                    std::min(0.5 * config_.cell_m / std::max(d.norm(), 1e-9), std::numbers::pi) / kSectorWidth;
                const int first = static_cast<int>(std::floor(middle - half));
                const int last = std::min(static_cast<int>(std::floor(middle + half)), first + kSweepSectors - 1);
                for (int s = first; s <= last; ++s) {
                    GridSector& sector =
                        sectors[static_cast<std::size_t>((s % kSweepSectors + kSweepSectors) % kSweepSectors)];
                    if (distance < sector.obstacle_m) {
                        sector.obstacle_m = distance;
                        sector.state = describe(cell);
                    }
                }
            }
        }
    }
    for (std::size_t k = 0; k < sectors.size(); ++k) {
        GridState worst{Space::kFree, 1.0F, 0.0F};
        double free = range;
        for (const double part : {1.0 / 6.0, 0.5, 5.0 / 6.0}) {
            const double azimuth = request.start_rad + (static_cast<double>(k) + part) * kSectorWidth;
            free = std::min(free, wedge_range(request, azimuth, worst));
        }
        GridSector& sector = sectors[k];
        sector.free_m = std::min(static_cast<float>(free), sector.obstacle_m);
        if (sector.state.space != Space::kOccupied) {
            sector.state = worst.space == Space::kFree ? worst : GridState{};
        }
    }
}

GridState OccupancyGrid::segment(const Eigen::Vector3d& from_W, const Eigen::Vector3d& to_W, double radius_m) const {
    GridState worst{Space::kFree, 1.0F, 0.0F};
    const Eigen::Vector3d d = to_W - from_W;
    const double length2 = d.squaredNorm();
    const Eigen::Vector3i low = cell_of((from_W.cwiseMin(to_W).array() - radius_m).matrix());
    const Eigen::Vector3i high = cell_of((from_W.cwiseMax(to_W).array() + radius_m).matrix());
    if (!holds(low) || !holds(high)) {
        return {};
    }
    for (int z = low.z(); z <= high.z(); ++z) {
        for (int y = low.y(); y <= high.y(); ++y) {
            for (int x = low.x(); x <= high.x(); ++x) {
                const Eigen::Vector3i c(x, y, z);
                const Eigen::Vector3d q = centre_of(c) - from_W;
                const double t = length2 > 0.0 ? std::clamp(q.dot(d) / length2, 0.0, 1.0) : 0.0;
                if ((q - t * d).squaredNorm() <= radius_m * radius_m) {
                    worsen(describe(cells_[index_of(c)]), worst);
                }
            }
        }
    }
    const double length = std::sqrt(length2);
    if (length > 0.0) {
        walk(config_.cell_m, from_W, d / length, length, [&](const Eigen::Vector3i& c, double) {
            worsen(describe(find(c)), worst);
            return true;
        });
    } else {
        worsen(at(from_W), worst);
    }
    return worst;
}

GridState OccupancyGrid::box(const Eigen::Vector3d& low_W, const Eigen::Vector3d& high_W) const {
    GridState worst{Space::kFree, 1.0F, 0.0F};
    const Eigen::Vector3i low = cell_of(low_W);
    const Eigen::Vector3i high = cell_of(high_W);
    if (!holds(low) || !holds(high)) {
        return {};
    }
    for (int z = low.z(); z <= high.z(); ++z) {
        for (int y = low.y(); y <= high.y(); ++y) {
            for (int x = low.x(); x <= high.x(); ++x) {
                worsen(describe(cells_[index_of({x, y, z})]), worst);
            }
        }
    }
    return worst;
}

}  // namespace facet
