// SPDX-License-Identifier: BSD-2-Clause
// What a planner receives of the world: the mesh over the horizon, its planes, and the grid around the vehicle.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace facet {

inline constexpr int kWorldVertices = 4096;
inline constexpr int kWorldFaces = 8192;
inline constexpr int kWorldPlanes = 16;
/// Cells of the grid along x, y, z; powers of two. Cell c is stored at c & (cells - 1) along each axis.
inline constexpr std::array<int, 3> kWorldCells = {128, 128, 64};
inline constexpr int kWorldBlockBytes = 128;  ///< 512 cells, two bits each: four rows of x
inline constexpr int kWorldGridBytes = kWorldCells[0] * kWorldCells[1] * kWorldCells[2] / 4;
inline constexpr int kWorldBlocks = kWorldGridBytes / kWorldBlockBytes;
inline constexpr int kWorldRun = 8;  ///< cells along x that share the time at which they were last confirmed
inline constexpr int kWorldRuns = kWorldCells[0] * kWorldCells[1] * kWorldCells[2] / kWorldRun;
inline constexpr int kWorldBlockRuns = kWorldRuns / kWorldBlocks;
inline constexpr double kWorldTick_s = 1.0 / 16.0;
inline constexpr int kWorldTicks = 0xffff;  ///< then they restart, at 1
inline constexpr std::uint32_t kNoWorldPlane = 0xffffffffU;

enum class WorldSpace : std::uint8_t { kUnknown, kFree, kOccupied };

/// What is known of a point.
struct WorldPoint {
    WorldSpace space = WorldSpace::kUnknown;
    float certainty = 0.0F;  ///< probability that this is right, at least; 0 if unknown
    /// Since it was last confirmed, at the state's stamp: of the kWorldRun cells along x that its cell is among, that
    /// of the oldest. 0 if unknown.
    float age_s = 0.0F;
};

/// A face, if is_used: counterclockwise as seen from the side it was observed from.
struct WorldFace {
    std::array<std::uint16_t, 3> vertex{};
    std::uint16_t observations = 0;       ///< keyframes that have confirmed it
    std::uint32_t plane = kNoWorldPlane;  ///< id of its plane
    float sigma_m = 0.0F;                 ///< standard deviation along its normal
    bool is_used = false;
    bool is_fill = false;  ///< closes a hole: no keyframe has shown it
    bool operator==(const WorldFace&) const = default;
};

/// n . p = d in W.
struct WorldPlane {
    std::uint32_t id = kNoWorldPlane;
    std::array<float, 3> normal_W{};
    float distance_m = 0.0F;
    bool operator==(const WorldPlane&) const = default;
};

/// The state after one keyframe. W: world, z up (m). About 1 MB, on the heap, allocated in the constructor.
struct WorldState {
    std::uint64_t sequence = 0;  ///< number of the keyframe, from 1; 0: nothing is known
    std::int64_t stamp_ns = 0;
    std::uint32_t resets = 0;           ///< of the estimator: if it changes, W is another one
    double cell_m = 0.0;                ///< edge of a cell; 0: there is no grid
    std::array<std::int32_t, 3> low{};  ///< the grid's lowest cell; cell c covers [c, c + 1) * cell_m
    std::uint16_t tick = 0;             ///< the grid's time, in kWorldTick_s, from 1 on
    std::vector<WorldPlane> planes;     ///< up to kWorldPlanes
    std::vector<std::array<float, 3>> vertices_W = std::vector<std::array<float, 3>>(kWorldVertices);
    std::vector<WorldFace> faces = std::vector<WorldFace>(kWorldFaces);            ///< keep their index while they live
    std::vector<std::uint8_t> cells = std::vector<std::uint8_t>(kWorldGridBytes);  ///< two bits a cell, x fastest
    /// How certain each cell is, in the same order: of levels 0 to 3, certainty_of() each.
    std::vector<std::uint8_t> levels = std::vector<std::uint8_t>(kWorldGridBytes);
    /// Tick at which each run of kWorldRun cells was last confirmed, the oldest that is not unknown; 0: all unknown.
    std::vector<std::uint16_t> confirmed = std::vector<std::uint16_t>(kWorldRuns);

    bool operator==(const WorldState&) const = default;

    /// Least certainty of a level: 1 / (1 + exp(-0.6 e)) for the grid's evidence e = 2, 3, 4, 5.
    static float certainty_of(int level) {
        constexpr std::array<float, 4> kCertainty = {0.769F, 0.858F, 0.917F, 0.953F};
        return kCertainty[static_cast<std::size_t>(level & 3)];
    }

    /// State of the space at a point; unknown outside the grid and without one.
    WorldSpace at(const std::array<double, 3>& p_W) const {
        const std::optional<std::size_t> index = index_of(p_W);
        return index ? space_of(*index) : WorldSpace::kUnknown;
    }
    /// The same with certainty and age.
    WorldPoint describe(const std::array<double, 3>& p_W) const {
        const std::optional<std::size_t> index = index_of(p_W);
        WorldPoint point;
        if (!index || space_of(*index) == WorldSpace::kUnknown) {
            return point;
        }
        point.space = space_of(*index);
        point.certainty = certainty_of(two_bits(levels, *index));
        const int ticks = (tick - confirmed[*index / kWorldRun] + kWorldTicks) % kWorldTicks;
        point.age_s = static_cast<float>(ticks * kWorldTick_s);
        return point;
    }

private:
    static int two_bits(const std::vector<std::uint8_t>& packed, std::size_t index) {
        return (packed[index / 4] >> (2 * (index % 4))) & 3;
    }
    WorldSpace space_of(std::size_t index) const {
        const int code = two_bits(cells, index);
        return code == 1 ? WorldSpace::kFree : code == 2 ? WorldSpace::kOccupied : WorldSpace::kUnknown;
    }
    /// Place of the cell that holds a point, if the grid has it.
    std::optional<std::size_t> index_of(const std::array<double, 3>& p_W) const {
        if (!(cell_m > 0.0)) {
            return std::nullopt;
        }
        std::size_t index = 0;
        for (std::size_t axis = 3; axis-- > 0;) {
            const double c = std::floor(p_W[axis] / cell_m);
            if (!(c >= low[axis]) || !(c < static_cast<double>(low[axis]) + kWorldCells[axis])) {
                return std::nullopt;
            }
            const auto cells_along = static_cast<std::size_t>(kWorldCells[axis]);
            index = index * cells_along + (static_cast<std::size_t>(static_cast<std::int64_t>(c)) & (cells_along - 1));
        }
        return index;
    }
};

}  // namespace facet
