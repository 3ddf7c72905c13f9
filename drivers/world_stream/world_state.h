// SPDX-License-Identifier: BSD-2-Clause
// What a planner is told of the world: the mesh over the horizon, its planes, and the grid around the vehicle.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
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
inline constexpr std::uint32_t kNoWorldPlane = 0xffffffffU;

enum class WorldSpace : std::uint8_t { kUnknown, kFree, kOccupied };

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

/// The state after one keyframe. W: world, z up (m). About 0.5 MB, on the heap, allocated in the constructor.
struct WorldState {
    std::uint64_t sequence = 0;  ///< number of the keyframe, from 1; 0: nothing is known
    std::int64_t stamp_ns = 0;
    std::uint32_t resets = 0;           ///< of the estimator: if it changes, W is another one
    double cell_m = 0.0;                ///< edge of a cell; 0: there is no grid
    std::array<std::int32_t, 3> low{};  ///< the grid's lowest cell; cell c covers [c, c + 1) * cell_m
    std::vector<WorldPlane> planes;     ///< up to kWorldPlanes
    std::vector<std::array<float, 3>> vertices_W = std::vector<std::array<float, 3>>(kWorldVertices);
    std::vector<WorldFace> faces = std::vector<WorldFace>(kWorldFaces);            ///< keep their index while they live
    std::vector<std::uint8_t> cells = std::vector<std::uint8_t>(kWorldGridBytes);  ///< two bits a cell, x fastest

    bool operator==(const WorldState&) const = default;

    /// State of the space at a point; unknown outside the grid and without one.
    WorldSpace at(const std::array<double, 3>& p_W) const {
        if (!(cell_m > 0.0)) {
            return WorldSpace::kUnknown;
        }
        std::size_t index = 0;
        for (std::size_t axis = 3; axis-- > 0;) {
            const double c = std::floor(p_W[axis] / cell_m);
            if (!(c >= low[axis]) || !(c < static_cast<double>(low[axis]) + kWorldCells[axis])) {
                return WorldSpace::kUnknown;
            }
            const auto cells_along = static_cast<std::size_t>(kWorldCells[axis]);
            index = index * cells_along + (static_cast<std::size_t>(static_cast<std::int64_t>(c)) & (cells_along - 1));
        }
        const int code = (cells[index / 4] >> (2 * (index % 4))) & 3;
        return code == 1 ? WorldSpace::kFree : code == 2 ? WorldSpace::kOccupied : WorldSpace::kUnknown;
    }
};

}  // namespace facet
