// SPDX-License-Identifier: BSD-2-Clause
// What the grid tells those who keep a copy, and what uncertain surfaces and single points do to it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "tests/mesh/grid_watcher.h"

namespace facet::grid_belief_test {
namespace {

using Eigen::Vector3d;
using test::looking_along_x;
using test::view_of;
using test::wall_at;
using Watcher = test::GridWatcher;
using World = test::MeshWorld;

const Se3 kHere = looking_along_x({0.03, 0.03, 0.03});

/// The grid's cells in the order in which they are packed: the place of cell c is that of c modulo the size.
template <class Visit>
void for_each_cell(const OccupancyGrid& grid, const Visit& visit) {
    const Eigen::Vector3i size(OccupancyGrid::kGridX, OccupancyGrid::kGridY, OccupancyGrid::kGridZ);
    const Eigen::Vector3i low = grid.lowest_cell();
    std::size_t place = 0;
    for (int z = 0; z < size.z(); ++z) {
        for (int y = 0; y < size.y(); ++y) {
            for (int x = 0; x < size.x(); ++x, ++place) {
                const Eigen::Vector3i at(x, y, z);
                const Eigen::Vector3i beyond = at - low;
                Eigen::Vector3i cell;
                for (int i = 0; i < 3; ++i) {
                    cell[i] = low[i] + ((beyond[i] % size[i]) + size[i]) % size[i];
                }
                visit(place, grid.at(grid.cell_m() * (cell.cast<double>() + Vector3d::Constant(0.5))));
            }
        }
    }
}

/// Evidence either way, from the probability that it stands for.
int evidence_of(const GridState& state) {
    const auto p = static_cast<double>(state.certainty);
    return static_cast<int>(std::lround(std::log(p / (1.0 - p)) / 0.6));
}

TEST_CASE("the packed belief says of every cell and run what the grid says itself") {
    // GIVEN walls of two ages, on both sides of cells that have been seen through once and often
    Watcher w;
    for (int k = 0; k < 3; ++k) {
        w.see(wall_at(3.05), kHere, 10.0 + 0.25 * k);
    }
    w.see(wall_at(2.05), looking_along_x({0.03, 0.83, 0.03}), 13.0);
    // WHEN states and belief are packed
    std::vector<std::uint8_t> states(OccupancyGrid::kPackedBytes);
    std::vector<std::uint8_t> levels(OccupancyGrid::kPackedBytes);
    std::vector<std::uint16_t> confirmed(OccupancyGrid::kRuns);
    w.grid->pack(std::span<std::uint8_t, OccupancyGrid::kPackedBytes>(states));
    w.grid->pack_belief(std::span<std::uint8_t, OccupancyGrid::kPackedBytes>(levels),
                        std::span<std::uint16_t, OccupancyGrid::kRuns>(confirmed));
    // THEN each cell's level is its evidence, and each run's tick as long ago as its oldest cell
    int known = 0;
    int wrong = 0;  // counted: a million checks by the test's library take a minute in a sanitizer
    int differing_levels = 0;
    std::vector<float> oldest_s(OccupancyGrid::kRuns, -1.0F);
    for_each_cell(*w.grid, [&](std::size_t place, const GridState& state) {
        const unsigned shift = 2U * static_cast<unsigned>(place % 4);
        const int code = (states[place / 4] >> shift) & 3;
        const int level = (levels[place / 4] >> shift) & 3;
        wrong += code == (state.space == Space::kFree ? 1 : state.space == Space::kOccupied ? 2 : 0) ? 0 : 1;
        if (state.space == Space::kUnknown) {
            wrong += level == 0 ? 0 : 1;
            return;
        }
        ++known;
        differing_levels |= 1 << level;
        wrong += level == std::min(evidence_of(state) - 2, 3) ? 0 : 1;
        float& oldest = oldest_s[place / OccupancyGrid::kRun];
        oldest = std::max(oldest, state.age_s);
    });
    CHECK(wrong == 0);
    CHECK(known > 5000);
    CHECK(differing_levels == 0xf);
    float most = 0.0F;
    for (std::size_t run = 0; run < OccupancyGrid::kRuns; ++run) {
        const bool is_known = oldest_s[run] >= 0.0F;
        const int ago = (w.grid->tick() - confirmed[run] + OccupancyGrid::kTicks) % OccupancyGrid::kTicks;
        const bool is_told = confirmed[run] > 0;
        wrong += is_told == is_known ? 0 : 1;
        wrong += is_known && std::abs(ago * OccupancyGrid::kTick_s - static_cast<double>(oldest_s[run])) > 1e-6 ? 1 : 0;
        most = std::max(most, oldest_s[run]);
    }
    CHECK(wrong == 0);
    CHECK(most == Approx(2.5F).margin(0.51));  // of the first wall
}

TEST_CASE("a point that one keyframe alone has seen makes space free with half the weight of a landmark") {
    // GIVEN the same point as a landmark of several keyframes, and as a surface point
    World single;
    single.points.push_back({1, {3.03, 0.03, 0.03}});
    const Vector3d halfway(1.53, 0.03, 0.03);
    Watcher of_landmark;
    Watcher of_surface;
    const auto landmark = view_of(single, kHere, 10);
    REQUIRE(landmark->landmarks.size() == 1);
    const auto surface = view_of(single, kHere, 10);
    surface->surface.push_back(surface->landmarks[0]);
    surface->surface[0].keyframes = surface->surface[0].stereo = 1;
    surface->landmarks.clear();
    // THEN one line of sight to the landmark is enough, and it takes two to the surface point
    of_landmark.see(*landmark, 10.0);
    CHECK(of_landmark.grid->at(halfway).space == Space::kFree);
    CHECK(of_landmark.grid->at({3.03, 0.03, 0.03}).space == Space::kOccupied);
    of_surface.see(*surface, 10.0);
    CHECK(of_surface.grid->at(halfway).space == Space::kUnknown);
    of_surface.see(*surface, 10.25);
    CHECK(of_surface.grid->at(halfway).space == Space::kFree);
    CHECK(of_surface.grid->at({3.03, 0.03, 0.03}).space != Space::kOccupied);  // nor is it an obstacle by itself
}

TEST_CASE("space within the uncertainty of a face is not free, although it has been seen through") {
    // GIVEN space that is free up to a wall far away
    Watcher w;
    for (int k = 0; k < 6; ++k) {
        w.see(wall_at(5.05), kHere, 10.0 + 0.25 * k);
    }
    const Vector3d before(2.93, 0.03, 0.03);
    REQUIRE(w.grid->at(before).space == Space::kFree);
    // WHEN a wall is found there whose distance is known to 12 cm only
    auto view = view_of(wall_at(3.05), kHere, 12);
    for (LandmarkSnapshot& s : view->landmarks) {
        s.id.value += 5000;
        s.depth_sigma_m = 0.12F;
        s.covariance_W = 0.0144F * Eigen::Matrix3f::Identity();
    }
    w.see(*view, 12.0);
    // THEN what lies a standard deviation before it is not known to be free any more; farther before, it is
    CHECK(w.grid->at({3.02, 0.03, 0.03}).space != Space::kFree);
    CHECK(w.grid->at(before).space != Space::kFree);
    CHECK(w.grid->at({2.03, 0.03, 0.03}).space == Space::kFree);
}

}  // namespace
}  // namespace facet::grid_belief_test
