// SPDX-License-Identifier: BSD-2-Clause
// How the grid is filled: occupancy_query.cpp has the questions.
#include "mesh/occupancy_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/grid_walk.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

// Lines of sight to a face are this far apart, and at least a cell (rad).
constexpr double kRaySpacing_rad = 0.018;
constexpr int kHit = 2;
// A face seen at a larger angle to its normal may bridge a step in depth: it makes no obstacle, but space that is not
// free.
constexpr double kObstacleGrazing_deg = 65.0;
constexpr int kMostFree = -6;
constexpr int kLandmarkWeight = 2;
constexpr int kSeenTwice = 2;          // keyframes: a face that frees the space before it
constexpr double kTargetSigmas = 2.0;  // a line of sight ends so many before its target
constexpr float kMaxPointChi2 = 6.0F;
constexpr double kMaxPathStep_m = 2.0;  // between keyframes: the path is not known well enough beyond
constexpr double kHitSpacing = 0.5;     // cells between the samples of a face,
constexpr double kMarkSpacing = 1.0;    // and parts of cells between them
constexpr double kPartMargin = 0.6;     // cells: parts are cleared up to here, less the target's uncertainty

/// Calls visit(point) for samples of a triangle, at most `spacing` apart.
template <class Visit>
void sample_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, double spacing,
                     Visit visit) {
    constexpr int kMost = 160;  // to a side: of 3 m at the default spacing
    const double longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    const int n = std::clamp(static_cast<int>(std::ceil(longest / spacing)), 1, kMost);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n - i; ++j) {
            const double u = (i + 1.0 / 3.0) / n;
            const double v = (j + 1.0 / 3.0) / n;
            visit((1.0 - u - v) * a + u * b + v * c);
        }
    }
}

/// Whether a point may be believed.
bool is_good(const LandmarkSnapshot& s) {
    return s.is_tracked && s.chi2 <= kMaxPointChi2 && s.depth_m > 0.0F && s.depth_sigma_m < 0.5F * s.depth_m;
}

/// Whether a landmark is known well enough to be an obstacle by itself.
bool is_obstacle(const LandmarkSnapshot& s, double cell_m) {
    return is_good(s) && s.keyframes >= 2 && static_cast<double>(s.depth_sigma_m) <= cell_m;
}

}  // namespace

Status OccupancyGrid::configure(const GridConfig& config) {
    FACET_TRY(config.validate());
    config_ = config;
    clear();
    return Status::kOk;
}

void OccupancyGrid::clear() {
    cells_.fill({});
    surface_.fill(0);
    any_ = false;
    tick_ = 1;
    layer_ = 0;
}

void OccupancyGrid::update(const KeyframeView& view, const HorizonMesh& mesh, std::uint32_t update) {
    advance(view.stamp);
    roll_to(view.T_W_C0.p);
    forget_layer();
    const Eigen::Vector3d before = any_ ? p_W_C_ : view.T_W_C0.p;
    any_ = true;
    p_W_C_ = view.T_W_C0.p;
    hit_faces(mesh, update);
    take_points(view);
    carve_faces(mesh, update);
    mark_surfaces(view, mesh, update);
    fly_to(before);
}

/// The time in ticks; after a gap in which ticks might have come round, nothing is known any more.
void OccupancyGrid::advance(Timestamp stamp) {
    if (any_ && ((stamp - last_).seconds() > kForget_s || stamp < last_)) {
        clear();
    }
    first_ = any_ ? first_ : stamp;
    last_ = stamp;
    const auto ticks = static_cast<std::int64_t>((stamp - first_).seconds() / kTick_s);
    tick_ = static_cast<std::uint16_t>(ticks % kTicks + 1);
}

/// Centres the grid on the vehicle. Cells that come in are those that go out at the other side, unknown.
void OccupancyGrid::roll_to(const Eigen::Vector3d& p_W) {
    const Eigen::Vector3i low = cell_of(p_W) - Eigen::Vector3i(kGridX / 2, kGridY / 2, kGridZ / 2);
    const Eigen::Vector3i size(kGridX, kGridY, kGridZ);
    for (int axis = 0; axis < 3; ++axis) {
        const int shift = std::clamp(low[axis] - low_[axis], -size[axis], size[axis]);
        for (int k = 0; k < std::abs(shift); ++k) {
            forget_slab(axis, shift > 0 ? low[axis] + size[axis] - 1 - k : low[axis] + k);
        }
    }
    low_ = low;
}

/// All cells with this number along one axis: `length` in a row, again every `pitch`.
void OccupancyGrid::forget_slab(int axis, int number) {
    constexpr std::size_t kLayer = static_cast<std::size_t>(kGridX) * kGridY;
    const std::size_t length = axis == 0 ? 1 : axis == 1 ? kGridX : kLayer;
    const std::size_t pitch = axis == 0 ? kGridX : axis == 1 ? kLayer : kCells;
    Eigen::Vector3i c = Eigen::Vector3i::Zero();
    c[axis] = number;
    for (std::size_t first = index_of(c); first < kCells; first += pitch) {
        std::fill_n(cells_.begin() + static_cast<std::ptrdiff_t>(first), length, Cell{});
    }
}

/// One layer a keyframe: cells that nothing has confirmed for long.
void OccupancyGrid::forget_layer() {
    const std::size_t area = static_cast<std::size_t>(kGridX) * kGridY;
    const auto most = static_cast<int>(kForget_s / kTick_s);
    for (std::size_t i = area * static_cast<std::size_t>(layer_); i < area * static_cast<std::size_t>(layer_ + 1);
         ++i) {
        const int age = (tick_ - cells_[i].tick + kTicks) % kTicks;
        if (cells_[i].tick != 0 && age > most) {
            cells_[i] = {};
        }
    }
    layer_ = (layer_ + 1) % kGridZ;
}

void OccupancyGrid::hit(const Eigen::Vector3d& p_W) {
    const Eigen::Vector3i c = cell_of(p_W);
    if (holds(c)) {
        hit(index_of(c));
    }
}

void OccupancyGrid::hit(std::size_t index) {
    Cell& cell = cells_[index];
    if (cell.evidence < kOccupied) {
        surface_[index] = 0;
    }
    if (cell.tick != tick_ || cell.evidence < kOccupied) {
        cell.evidence = static_cast<std::int8_t>(std::min(std::max<int>(cell.evidence, 0) + kHit, kMostOccupied));
        cell.tick = tick_;
    }
}

/// Where an uncertain surface may be as well: no longer free, and not carved at this keyframe.
void OccupancyGrid::doubt(const Eigen::Vector3d& p_W) {
    const Eigen::Vector3i c = cell_of(p_W);
    if (!holds(c)) {
        return;
    }
    Cell& cell = cells_[index_of(c)];
    if (cell.tick != tick_) {
        cell.evidence = static_cast<std::int8_t>(std::max<int>(cell.evidence, kFree + 1));
        cell.tick = tick_;
    }
}

/// Whether the keyframe sees a face so steeply that it may bridge the step from one surface to the next. Along a
/// straight edge such faces lie in one plane, so that the mesh takes them for a slanted surface.
bool OccupancyGrid::may_bridge(const HorizonMesh& mesh, const MeshFace& face) const {
    const Eigen::Vector3d ray = mesh.centroid(face) - p_W_C_;
    const double least_cosine = std::cos(kObstacleGrazing_deg * kRadPerDeg);
    return std::abs(ray.dot(face.normal_W.cast<double>())) < least_cosine * ray.norm();
}

void OccupancyGrid::hit_faces(const HorizonMesh& mesh, std::uint32_t update) {
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (!mesh.is_face(i) || mesh.face(static_cast<FaceIndex>(i)).last_confirmed != update) {
            continue;
        }
        const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
        const double sigma = std::min(static_cast<double>(face.sigma_m), 4.0 * config_.cell_m);
        const bool is_thick = sigma > 0.5 * config_.cell_m;
        const bool is_obstacle = !may_bridge(mesh, face);
        const Eigen::Vector3d off = sigma * face.normal_W.cast<double>();
        const auto visit = [&](const Eigen::Vector3d& p) { is_obstacle ? hit(p) : doubt(p); };
        const auto around = [&](const Eigen::Vector3d& p) {
            doubt(p + off);
            doubt(p - off);
        };
        const double spacing = kHitSpacing * config_.cell_m;
        sample_triangle(mesh.corner(face, 0), mesh.corner(face, 1), mesh.corner(face, 2), spacing, visit);
        if (is_thick) {
            sample_triangle(mesh.corner(face, 0), mesh.corner(face, 1), mesh.corner(face, 2), config_.cell_m, around);
        }
    }
}

/// A surface is in the part of a cell where the point is, and so the cell is occupied.
void OccupancyGrid::mark(const Eigen::Vector3d& p_W) {
    const Eigen::Vector3i part = part_of(p_W);
    const Eigen::Vector3i c = part.unaryExpr([](int i) { return i >> kPartBits; });
    if (holds(c)) {
        const std::size_t index = index_of(c);
        hit(index);
        surface_[index] |= part_bit(part);
    }
}

/// Which parts of occupied cells this keyframe's surfaces lie in. A landmark by itself occupies its whole cell.
void OccupancyGrid::mark_surfaces(const KeyframeView& view, const HorizonMesh& mesh, std::uint32_t update) {
    const double spacing = kMarkSpacing * config_.cell_m / kParts;
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (!mesh.is_face(i) || mesh.face(static_cast<FaceIndex>(i)).last_confirmed != update) {
            continue;
        }
        const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
        if (!may_bridge(mesh, face)) {
            sample_triangle(mesh.corner(face, 0), mesh.corner(face, 1), mesh.corner(face, 2), spacing,
                            [this](const Eigen::Vector3d& p) { mark(p); });
        }
    }
    for (const LandmarkSnapshot& s : view.landmarks) {
        const Eigen::Vector3i c = cell_of(s.p_W);
        if (is_obstacle(s, config_.cell_m) && holds(c) && surface_[index_of(c)] != 0) {
            mark(s.p_W);
        }
    }
}

/// Free space from the camera to a point, its own surroundings aside.
void OccupancyGrid::carve(const Eigen::Vector3d& p_W, double sigma_m, int weight) {
    const Eigen::Vector3d ray = p_W - p_W_C_;
    const double distance = ray.norm();
    const double seen = distance - kTargetSigmas * sigma_m;
    const double end = std::min(seen - config_.cell_m, config_.max_ray_m);
    const double end_of_parts = std::min(seen - kPartMargin * config_.cell_m, config_.max_ray_m);
    if (!(end > 0.0)) {
        return;
    }
    const Eigen::Vector3d direction = ray / distance;
    // The last cell entered ends at most its diagonal farther.
    walk(config_.cell_m, p_W_C_, direction, end_of_parts, [&](const Eigen::Vector3i& c, double entered) {
        if (!holds(c)) {
            return false;
        }
        Cell& cell = cells_[index_of(c)];
        if (cell.evidence >= kOccupied) {
            clear_parts(c, direction, entered, end_of_parts);
        }
        if (cell.tick != tick_ && entered <= end) {
            cell.evidence = static_cast<std::int8_t>(std::max(cell.evidence - weight, kMostFree));
            cell.tick = tick_;
        }
        return true;
    });
}

/// A line of sight from the camera passes an occupied cell: its surface is where the line is not. Whether there is one
/// at all is for the cell's evidence to say, so the last parts stay.
void OccupancyGrid::clear_parts(const Eigen::Vector3i& c, const Eigen::Vector3d& direction, double entered,
                                double end) {
    const double length = std::min(end - entered, std::numbers::sqrt3 * config_.cell_m);
    std::uint64_t passed = 0;
    walk(config_.cell_m / kParts, p_W_C_ + entered * direction, direction, length,
         [&](const Eigen::Vector3i& part, double) {
             passed |= is_part_of(part, c) ? part_bit(part) : 0;
             return true;
         });
    std::uint64_t& surface = surface_[index_of(c)];
    surface = (surface & ~passed) != 0 ? surface & ~passed : surface;
}

void OccupancyGrid::carve_faces(const HorizonMesh& mesh, std::uint32_t update) {
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (!mesh.is_face(i) || mesh.face(static_cast<FaceIndex>(i)).last_confirmed != update) {
            continue;
        }
        const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
        if (face.observations < kSeenTwice) {
            continue;  // it may bridge from one side of a thin thing to the other
        }
        const double range = (mesh.centroid(face) - p_W_C_).norm();
        const double spacing = std::max(config_.cell_m, kRaySpacing_rad * range);
        sample_triangle(mesh.corner(face, 0), mesh.corner(face, 1), mesh.corner(face, 2), spacing,
                        [&](const Eigen::Vector3d& p) { carve(p, static_cast<double>(face.sigma_m), kPointWeight); });
    }
}

/// Landmarks and surface points: all that can be trusted are seen through free space, those well known are obstacles.
void OccupancyGrid::take_points(const KeyframeView& view) {
    for (const LandmarkSnapshot& s : view.landmarks) {
        if (is_obstacle(s, config_.cell_m)) {
            hit(s.p_W);
        }
    }
    for (const LandmarkSnapshot& s : view.landmarks) {
        if (is_good(s)) {
            carve(s.p_W, static_cast<double>(s.depth_sigma_m), s.keyframes >= 2 ? kLandmarkWeight : kPointWeight);
        }
    }
    for (const LandmarkSnapshot& s : view.surface) {
        if (is_good(s)) {
            carve(s.p_W, static_cast<double>(s.depth_sigma_m), kPointWeight);
        }
    }
}

/// The vehicle was where it is, and on the way.
/// @param before_W  where the camera was at the last keyframe (m)
void OccupancyGrid::fly_to(const Eigen::Vector3d& before_W) {
    const double length = (p_W_C_ - before_W).norm();
    const double r = config_.body_radius_m;
    const int steps = length > kMaxPathStep_m ? 0 : static_cast<int>(std::ceil(2.0 * length / config_.cell_m));
    for (int i = 0; i <= steps; ++i) {
        const Eigen::Vector3d p = p_W_C_ + (steps > 0 ? static_cast<double>(i) / steps : 0.0) * (before_W - p_W_C_);
        const Eigen::Vector3i low = cell_of(p.array() - r);
        const Eigen::Vector3i high = cell_of(p.array() + r);
        for (int z = low.z(); z <= high.z(); ++z) {
            for (int y = low.y(); y <= high.y(); ++y) {
                for (int x = low.x(); x <= high.x(); ++x) {
                    const Eigen::Vector3i c(x, y, z);
                    if (holds(c) && (c == cell_of(p) || (centre_of(c) - p).squaredNorm() <= r * r)) {
                        cells_[index_of(c)] = {kMostFree, tick_};
                    }
                }
            }
        }
    }
}

GridState OccupancyGrid::describe(Cell cell) const {
    GridState state{.space = space_of(cell)};
    if (state.space != Space::kUnknown) {
        constexpr double kSlope = 0.6;
        state.certainty = static_cast<float>(1.0 / (1.0 + std::exp(-kSlope * std::abs(cell.evidence))));
        state.age_s = static_cast<float>(age_ticks(cell) * kTick_s);
    }
    return state;
}

void OccupancyGrid::pack(std::span<std::uint8_t, kPackedBytes> states) const {
    const auto code = [](Cell cell) {
        return static_cast<unsigned>(cell.evidence <= kFree) + 2U * static_cast<unsigned>(cell.evidence >= kOccupied);
    };
    for (std::size_t i = 0; i < states.size(); ++i) {
        const Cell* const four = &cells_[4 * i];
        states[i] = static_cast<std::uint8_t>(code(four[0]) | (code(four[1]) << 2U) | (code(four[2]) << 4U) |
                                              (code(four[3]) << 6U));
    }
}

void OccupancyGrid::pack_belief(std::span<std::uint8_t, kPackedBytes> levels,
                                std::span<std::uint16_t, kRuns> confirmed) const {
    const auto level = [](Cell cell) {
        static_assert(kFree == -kOccupied);
        return static_cast<unsigned>(std::clamp(std::abs(cell.evidence) - kOccupied, 0, 3));
    };
    for (std::size_t i = 0; i < levels.size(); ++i) {
        const Cell* const four = &cells_[4 * i];
        levels[i] = static_cast<std::uint8_t>(level(four[0]) | (level(four[1]) << 2U) | (level(four[2]) << 4U) |
                                              (level(four[3]) << 6U));
    }
    for (std::size_t i = 0; i < confirmed.size(); ++i) {
        int oldest = -1;
        for (std::size_t k = kRun * i; k < kRun * (i + 1); ++k) {
            const bool is_known = std::abs(cells_[k].evidence) >= kOccupied;
            const int since = tick_ - cells_[k].tick;
            oldest = std::max(oldest, is_known ? since + (since < 0 ? kTicks : 0) : -1);
        }
        // The tick that is so long ago; they run from 1 to kTicks.
        confirmed[i] = static_cast<std::uint16_t>(oldest < 0 ? 0 : (tick_ - 1 - oldest + kTicks) % kTicks + 1);
    }
}

std::array<int, 3> OccupancyGrid::count() const {
    std::array<int, 3> count{};
    for (const Cell cell : cells_) {
        ++count[static_cast<std::size_t>(space_of(cell))];
    }
    return count;
}

}  // namespace facet
