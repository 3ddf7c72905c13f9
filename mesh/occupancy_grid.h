// SPDX-License-Identifier: BSD-2-Clause
// Free, occupied and unknown space around the vehicle, for obstacle avoidance.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "estimator/values/keyframe_view.h"
#include "mesh/capacity.h"
#include "mesh/depth_point.h"
#include "mesh/grid_config.h"
#include "mesh/horizon_mesh.h"

namespace facet {

/// Ordered by what a planner has to fear: the worse one counts.
enum class Space : std::uint8_t { kFree, kUnknown, kOccupied };

/// What a stretch or a volume of space is.
struct GridState {
    Space space = Space::kUnknown;
    /// Probability that the state is right, of the least certain cell that decides it; 0 if unknown.
    float certainty = 0.0F;
    float age_s = 0.0F;  ///< since the oldest of these cells was last confirmed; 0 if unknown
};

/// What lies along a ray.
struct GridRay {
    GridState end;                                                ///< what ends the free stretch; free: nothing does
    double free_m = 0.0;                                          ///< length of the stretch that is known to be free
    double obstacle_m = std::numeric_limits<double>::infinity();  ///< to the first occupied cell, also behind unknown
};

/// What is nearest to a point.
struct GridNearest {
    double obstacle_m = std::numeric_limits<double>::infinity();  ///< to the nearest occupied cell (its nearest point)
    double unknown_m = std::numeric_limits<double>::infinity();   ///< to the nearest unknown one
    Eigen::Vector3d obstacle_W = Eigen::Vector3d::Zero();         ///< centre of the occupied cell (m)
    GridState obstacle;
};

/// What a sweep covers; azimuths as in SweepRequest (range_query.h).
struct GridSweepRequest {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< the vehicle (m)
    double start_rad = 0.0;                         ///< azimuth where sector 0 begins
    double below_m = 0.5;                           ///< obstacles from this much below the vehicle
    double above_m = 0.5;                           ///< to this much above it count
    double wedge_m = 0.15;                          ///< half the height, at the full range, of the wedge to be free
    double max_range_m = 6.0;
};

/// A sector of a sweep.
struct GridSector {
    float obstacle_m = std::numeric_limits<float>::infinity();  ///< nearest occupied cell in the sector and band
    float free_m = 0.0F;                                        ///< up to there the wedge is free
    GridState state;  ///< occupied: an obstacle in range; free: none, and free to the full range; else unknown
};

/// A grid of kGridX x kGridY x kGridZ cubes, aligned with W, that rolls with the vehicle: what leaves it is forgotten.
/// Each cell counts evidence e, positive for occupied:
///   hit    e <- max(e, 0) + 2, at most 5: a face of the mesh that the keyframe confirms, or a landmark, is in it
///   doubt  e <- max(e, -1): an uncertain face may be in it, or one seen so steeply that it may bridge a step in depth
///   carve  e <- e - w, at least -6: a line of sight from the camera has passed it; w = 2 to a landmark of several
///          views, w = 1 to any other point or a face. It ends a cell and two standard deviations before its target
///   flown  e <- -6: the vehicle was there
/// at most once a keyframe, hits first: a line of sight that grazes a surface does not carve it. A cell is occupied if
/// e >= 2, free if e <= -2, else unknown; the probability of being occupied is 1 / (1 + exp(-0.6 e)). An obstacle is
/// thus known from one keyframe; where it has left, space is free after four to seven keyframes that see through it
/// (movers), and never while nothing is seen behind it.
///
/// An occupied cell also knows which of its 4 x 4 x 4 parts hold a surface: those where faces and depth points have
/// been since something first spoke for it, and that no line of sight has passed since it is occupied. A ray is ended
/// by parts, so that it may pass a true surface closely, as a planner's does along a wall; space between the parts
/// counts as free. All other questions are answered by whole cells. Deterministic. Thread-bound. No heap. About 12 MB.
class OccupancyGrid {
public:
    static constexpr int kGridX = 128;
    static constexpr int kGridY = 128;
    static constexpr int kGridZ = 64;

    OccupancyGrid() { clear(); }
    /// @return kInvalidArgument if a field is out of range (nothing changed). Forgets everything.
    Status configure(const GridConfig& config);
    /// Forgets everything: after a jump of the estimate.
    void clear();

    /// Takes in a keyframe.
    /// @param update  number under which the mesh has observed its faces at this keyframe (MeshCounters::updates)
    void update(const KeyframeView& view, const HorizonMesh& mesh, std::uint32_t update);

    /// Takes in points of the same keyframe as the last update().
    void add_depth(std::span<const DepthPoint> points);

    /// State of the space at a point.
    GridState at(const Eigen::Vector3d& p_W) const { return describe(find(cell_of(p_W))); }
    /// Whether a ray ends there: in an occupied cell, in a part of it that holds a surface.
    bool has_surface(const Eigen::Vector3d& p_W) const {
        const Eigen::Vector3i c = cell_of(p_W);
        const std::uint64_t surface = holds(c) ? surface_[index_of(c)] : 0;
        return space_of(find(c)) == Space::kOccupied && (surface == 0 || (surface & part_bit(part_of(p_W))) != 0);
    }
    /// Along a ray. @param direction  of any length but zero
    GridRay cast(const Eigen::Vector3d& p_W, const Eigen::Vector3d& direction, double max_range_m) const;
    /// Nearest occupied and unknown cells. The time grows with the cube of the distance to them.
    GridNearest nearest(const Eigen::Vector3d& p_W, double max_range_m) const;
    /// The same among cells whose centres lie within a cone. @param half_angle_rad  (0, pi/2)
    GridNearest nearest_in_direction(const Eigen::Vector3d& p_W, const Eigen::Vector3d& direction,
                                     double half_angle_rad, double max_range_m) const;
    /// All around, horizontally.
    void sweep(const GridSweepRequest& request, std::span<GridSector, kSweepSectors> sectors) const;
    /// The worst state of the cells whose centres are within radius_m of a segment, and of those it passes.
    GridState segment(const Eigen::Vector3d& from_W, const Eigen::Vector3d& to_W, double radius_m) const;
    /// The worst state of the cells that a box, aligned with W, touches.
    GridState box(const Eigen::Vector3d& low_W, const Eigen::Vector3d& high_W) const;

    /// Cells in each state, by Space. Looks at all of them.
    std::array<int, 3> count() const;
    double cell_m() const { return config_.cell_m; }
    /// The corner cell: cell c covers [c, c + 1) cell_m() along each axis, and the grid holds kGridX x kGridY x kGridZ.
    Eigen::Vector3i lowest_cell() const { return low_; }
    static constexpr double kTick_s = 1.0 / 16.0;
    /// Cells that nothing has confirmed for this time are unknown again.
    static constexpr double kForget_s = 600.0;
    static constexpr int kTicks = 0xffff;
    static constexpr std::size_t kRun = 8;
    static constexpr std::size_t kRuns = static_cast<std::size_t>(kGridX) * kGridY * kGridZ / kRun;
    static constexpr std::size_t kPackedBytes = static_cast<std::size_t>(kGridX) * kGridY * kGridZ / 4;
    /// All states, two bits each from the low ones on: 0 unknown, 1 free, 2 occupied. Cell c has the place
    /// ((c.z mod kGridZ) kGridY + c.y mod kGridY) kGridX + c.x mod kGridX.
    void pack(std::span<std::uint8_t, kPackedBytes> states) const;
    /// How certain the states are and since when, for those who keep them: in the same order, two bits a cell, e - 2
    /// for evidence of 2 to 5 and beyond, either way; and for each run of kRun cells the tick() at which the oldest of
    /// them that is not unknown was last confirmed, 0 if all are unknown.
    void pack_belief(std::span<std::uint8_t, kPackedBytes> levels, std::span<std::uint16_t, kRuns> confirmed) const;
    /// The newest keyframe in kTick_s, from 1 to kTicks and then again from 1.
    std::uint16_t tick() const { return tick_; }

private:
    static_assert((kGridX & (kGridX - 1)) == 0 && (kGridY & (kGridY - 1)) == 0 && (kGridZ & (kGridZ - 1)) == 0);
    struct Cell {
        std::int8_t evidence = 0;
        std::uint16_t tick = 0;  ///< when it was last changed or confirmed; 0: never
    };

    Eigen::Vector3i cell_of(const Eigen::Vector3d& p_W) const {
        return (p_W / config_.cell_m).array().floor().cast<int>();
    }
    Eigen::Vector3d centre_of(const Eigen::Vector3i& c) const {
        return config_.cell_m * (c.cast<double>().array() + 0.5).matrix();
    }
    bool holds(const Eigen::Vector3i& c) const {
        return (c - low_).minCoeff() >= 0 && c.x() < low_.x() + kGridX && c.y() < low_.y() + kGridY &&
               c.z() < low_.z() + kGridZ;
    }
    static std::size_t index_of(const Eigen::Vector3i& c) {
        return (static_cast<std::size_t>(c.z() & (kGridZ - 1)) * kGridY +
                static_cast<std::size_t>(c.y() & (kGridY - 1))) *
                   kGridX +
               static_cast<std::size_t>(c.x() & (kGridX - 1));
    }
    static constexpr int kPartBits = 2;
    static constexpr int kParts = 1 << kPartBits;  ///< of a cell along each axis
    Eigen::Vector3i part_of(const Eigen::Vector3d& p_W) const {
        return (p_W * (kParts / config_.cell_m)).array().floor().cast<int>();
    }
    static bool is_part_of(const Eigen::Vector3i& part, const Eigen::Vector3i& c) {
        const Eigen::Vector3i inside = part - kParts * c;
        return inside.minCoeff() >= 0 && inside.maxCoeff() < kParts;
    }
    /// Its bit in surface_. Parts and cells are numbered alike, so its place in the cell is its lowest bits.
    static std::uint64_t part_bit(const Eigen::Vector3i& part) {
        constexpr int kLow = kParts - 1;
        return std::uint64_t{1} << static_cast<unsigned>(((part.z() & kLow) * kParts + (part.y() & kLow)) * kParts +
                                                         (part.x() & kLow));
    }
    /// The cell, or an unknown one outside the grid.
    Cell find(const Eigen::Vector3i& c) const { return holds(c) ? cells_[index_of(c)] : Cell{}; }
    static Space space_of(Cell cell) {
        return cell.evidence >= kOccupied ? Space::kOccupied : cell.evidence <= kFree ? Space::kFree : Space::kUnknown;
    }
    int age_ticks(Cell cell) const { return (tick_ - cell.tick + kTicks) % kTicks; }
    GridState describe(Cell cell) const;
    static void worsen(const GridState& by, GridState& state);

    /// Calls visit(cube, distance at which it is entered) for the cubes of a size along a ray until it returns false,
    /// or past max_m.
    template <class Visit>
    static void walk(double size, const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double max_m,
                     Visit visit);
    double surface_in(const Eigen::Vector3i& c, const Eigen::Vector3d& from, const Eigen::Vector3d& direction,
                      double entered) const;

    void advance(Timestamp stamp);
    void roll_to(const Eigen::Vector3d& p_W);
    void forget_slab(int axis, int number);
    void forget_layer();
    bool may_bridge(const HorizonMesh& mesh, const MeshFace& face) const;
    void hit_faces(const HorizonMesh& mesh, std::uint32_t update);
    void hit(const Eigen::Vector3d& p_W);
    void hit(std::size_t index);
    void hint(const Eigen::Vector3d& p_W);
    void mark(const Eigen::Vector3d& p_W);
    void mark_surfaces(const KeyframeView& view, const HorizonMesh& mesh, std::uint32_t update);
    void clear_parts(const Eigen::Vector3i& c, const Eigen::Vector3d& direction, double entered, double end);
    void doubt(const Eigen::Vector3d& p_W);
    void carve(const Eigen::Vector3d& p_W, double sigma_m, int weight);
    void carve_faces(const HorizonMesh& mesh, std::uint32_t update);
    void take_points(const KeyframeView& view);
    void fly_to(const Eigen::Vector3d& p_W);
    template <class IsIn>
    GridNearest search(const Eigen::Vector3d& p_W, double max_range_m, IsIn is_in) const;
    double wedge_range(const GridSweepRequest& request, double azimuth_rad, GridState& worst) const;

    static constexpr int kOccupied = 2;
    static constexpr int kFree = -2;
    static constexpr int kMostOccupied = 5;
    static constexpr int kPointWeight = 1;

    GridConfig config_;
    Eigen::Vector3i low_ = Eigen::Vector3i::Zero();  ///< the corner cell
    Eigen::Vector3d p_W_C_ = Eigen::Vector3d::Zero();
    bool any_ = false;
    Timestamp first_;
    Timestamp last_;
    std::uint16_t tick_ = 1;  ///< of the newest keyframe, in kTick_s, without 0
    int layer_ = 0;           ///< next one of forget_layer
    static constexpr std::size_t kCells = static_cast<std::size_t>(kGridX) * kGridY * kGridZ;
    std::array<Cell, kCells> cells_;
    std::array<std::uint64_t, kCells> surface_;  ///< of cells with e > 0: parts that hold a surface, or 0: all
};

}  // namespace facet
