// SPDX-License-Identifier: BSD-2-Clause
// How far it is from anywhere around the vehicle to the nearest obstacle, for planners that follow gradients.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "mesh/occupancy_grid.h"
#include "platform/base/status.h"

namespace facet {

/// What a distance field measures the distance to.
enum class FieldTarget : std::uint8_t {
    kOccupied,  ///< obstacles
    kNotFree,   ///< whatever is not known to be free; the grid's outermost cells count as unknown
};

/// What the field says of a point.
struct FieldPoint {
    Space space = Space::kUnknown;  ///< of the cell that the point is in; unknown outside the grid
    /// To the centre of the nearest target cell, interpolated between the cells' centres; reach_m() if it is farther,
    /// and outside the grid. The surface in that cell is nearer by up to 0.87 cells.
    double distance_m = 0.0;
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< of distance_m: away from the target; zero beyond reach
    bool has_target = false;                             ///< the target nearest to the cell's centre is within reach:
    Eigen::Vector3d target_W = Eigen::Vector3d::Zero();  ///< its cell's centre (m)
    Space target = Space::kUnknown;                      ///< what it is
};

/// Exact Euclidean distances between cell centres, up to a reach of at most kMaxReach cells, over all of the grid:
/// three separable passes, along z by sweeps, along y and x as minimum over the offsets d of f(c + d) + d^2
/// [Felzenszwalb12, restricted to the reach], each of which also keeps the offset, so that the nearest cell is known.
/// Takes the states as OccupancyGrid::pack() gives them and as WorldState::cells of the world stream has them, so that
/// it works in the program and in a planner at the stream's other end alike.
///
/// The time is bounded, whatever the grid holds (`mesh_bench`), and the result depends on nothing but
/// the states. Certainty and age of an obstacle are the grid's: OccupancyGrid::at(target_W). Thread-bound. No heap.
/// About 5.4 MB: allocate it once.
class DistanceField {
public:
    static constexpr int kMaxReach = 22;  ///< cells: sums of squares and an offset fit into 16 bits

    DistanceField() { clear(); }
    /// Nothing is known any more.
    void clear();

    /// Measures again.
    /// @param states       as OccupancyGrid::pack()
    /// @param lowest_cell  the grid's corner
    /// @param reach_m      distances matter up to here; cut down to kMaxReach cells
    /// @return kInvalidArgument if cell_m or reach_m is not positive (nothing changed)
    Status update(std::span<const std::uint8_t, OccupancyGrid::kPackedBytes> states, const Eigen::Vector3i& lowest_cell,
                  double cell_m, double reach_m, FieldTarget target);
    /// The same of a grid.
    Status update(const OccupancyGrid& grid, double reach_m, FieldTarget target);

    /// Reach in whole cells (m).
    double reach_m() const { return reach_ * cell_m_; }
    FieldPoint at(const Eigen::Vector3d& p_W) const;

private:
    static constexpr int kX = OccupancyGrid::kGridX;
    static constexpr int kY = OccupancyGrid::kGridY;
    static constexpr int kZ = OccupancyGrid::kGridZ;
    static constexpr std::size_t kPlane = static_cast<std::size_t>(kX) * kY;
    static constexpr std::size_t kCells = kPlane * kZ;
    /// A squared distance in the high bits, an offset + kMiddle in the low ones: the least key has the least distance.
    using Key = std::uint16_t;
    static constexpr int kOffsetBits = 6;
    static constexpr int kMiddle = 32;

    static std::size_t index_of(const Eigen::Vector3i& relative) {
        return (static_cast<std::size_t>(relative.z()) * kY + static_cast<std::size_t>(relative.y())) * kX +
               static_cast<std::size_t>(relative.x());
    }
    Space space_at(const Eigen::Vector3i& relative) const;
    void mark_targets(FieldTarget target);
    void sweep_z();
    void reduce_y();
    void reduce_x();
    double cell_distance_m(const Eigen::Vector3i& relative) const;

    double cell_m_ = 0.0;  ///< 0: nothing is known
    int reach_ = 0;        ///< cells
    Eigen::Vector3i low_ = Eigen::Vector3i::Zero();
    std::array<std::uint8_t, OccupancyGrid::kPackedBytes> states_{};
    // By cell, counted from the lowest one, x fastest:
    std::array<std::int8_t, kCells> offset_z_{};  ///< to the nearest target of the column; reach_ + 1: none
    std::array<Key, kCells> key_yz_{};            ///< to the nearest one of the plane across x
    std::array<Key, kCells> key_{};               ///< to the nearest one
    /// Scratch of reduce_y: a plane's squares, with rows of none before and behind.
    std::array<Key, static_cast<std::size_t>(kY + 2 * kMaxReach) * kX> squares_{};
};

}  // namespace facet
