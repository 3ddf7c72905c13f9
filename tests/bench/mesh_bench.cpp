// SPDX-License-Identifier: BSD-2-Clause
// Times of the mesh's parts. Budgets on one core: Delaunay of 300 points 0.15 ms, a sweep over a full mesh 0.2 ms, an
// update of the mesher 1 ms, one of the grid 3 ms, a distance field over all of the grid 6 ms.
#include <benchmark/benchmark.h>

#include <array>
#include <memory>
#include <random>
#include <vector>

#include "mesh/delaunay.h"
#include "mesh/distance_field.h"
#include "mesh/occupancy_grid.h"
#include "mesh/range_query.h"
#include "tests/mesh/keyframe_samples.h"
#include "tests/mesh/mesh_samples.h"

namespace {

using namespace facet;

void delaunay(benchmark::State& state) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> uniform(-0.8, 0.8);
    std::vector<Eigen::Vector2d> points;
    for (std::int64_t i = 0; i < state.range(0); ++i) {
        const double x = uniform(random);
        points.emplace_back(x, 0.64 * uniform(random));
    }
    const auto triangulation = std::make_unique<Delaunay>();
    for (auto _ : state) {
        benchmark::DoNotOptimize(triangulation->triangulate(points));
        benchmark::ClobberMemory();
    }
}
BENCHMARK(delaunay)->Arg(100)->Arg(300)->Arg(512)->Unit(benchmark::kMicrosecond);

/// Obstacles scattered over the grid, as many as asked for; all else is free.
void distance_field(benchmark::State& state) {
    std::vector<std::uint8_t> cells(OccupancyGrid::kPackedBytes, 0x55);
    std::mt19937 random(3);
    for (std::int64_t i = 0; i < state.range(0); ++i) {
        cells[random() % cells.size()] = 0x56;
    }
    const auto field = std::make_unique<DistanceField>();
    for (auto _ : state) {
        const std::span<const std::uint8_t, OccupancyGrid::kPackedBytes> states(cells);
        benchmark::DoNotOptimize(field->update(states, {-70, 33, -20}, 0.1, 2.0, FieldTarget::kOccupied));
        benchmark::ClobberMemory();
    }
}
BENCHMARK(distance_field)->Arg(0)->Arg(300)->Arg(20000)->Unit(benchmark::kMillisecond);

struct FullMesh {
    FullMesh() { query->update(*test::random_mesh(kMaxMeshFaces, 9)); }
    std::unique_ptr<RangeQuery> query = std::make_unique<RangeQuery>();
};

/// Where the vehicle is in the k-th query.
Eigen::Vector3d place(int k) { return {0.1 * (k % 30), 0.2, 0.0}; }

void sweep(benchmark::State& state) {
    const FullMesh full;
    std::array<double, kSweepSectors> range{};
    int k = 0;
    for (auto _ : state) {
        SweepRequest request;
        request.p_W = place(k++);
        full.query->sweep(request, range);
        benchmark::DoNotOptimize(range);
    }
}
BENCHMARK(sweep)->Unit(benchmark::kMicrosecond);

void nearest(benchmark::State& state) {
    const FullMesh full;
    int k = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(full.query->nearest(place(k++), 10.0));
    }
}
BENCHMARK(nearest)->Unit(benchmark::kMicrosecond);

void cast(benchmark::State& state) {
    const FullMesh full;
    int k = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(full.query->cast(place(k++), Eigen::Vector3d::UnitX(), 10.0));
    }
}
BENCHMARK(cast)->Unit(benchmark::kMicrosecond);

void nearest_in_cone(benchmark::State& state) {
    const FullMesh full;
    int k = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(full.query->nearest_in_direction(place(k++), Eigen::Vector3d::UnitX(), 0.2, 10.0));
    }
}
BENCHMARK(nearest_in_cone)->Unit(benchmark::kMicrosecond);

/// A camera that flies along a wall with furniture: 250 tracked landmarks, as many recent ones.
void mesher_update(benchmark::State& state) {
    test::WallFlight flight;
    std::vector<std::unique_ptr<KeyframeView>> views;
    for (int k = 0; k < 60; ++k) {
        views.push_back(flight.view(k));
    }
    const auto mesher = std::make_unique<Mesher>();
    if (!ok(mesher->configure({}, test::mesh_camera()))) {
        state.SkipWithError("configuration refused");
        return;
    }
    std::size_t k = 0;
    for (auto _ : state) {
        if (k == 0) {
            state.PauseTiming();
            mesher->reset();
            state.ResumeTiming();
        }
        mesher->update(*views[k], {});
        k = (k + 1) % views.size();
    }
    state.counters["faces"] = mesher->mesh().face_count();
}
BENCHMARK(mesher_update)->Unit(benchmark::kMicrosecond);

/// The grid at the same keyframes.
void grid_update(benchmark::State& state) {
    const test::WallFlight flight;
    const auto mesher = std::make_unique<Mesher>();
    if (!ok(mesher->configure({}, test::mesh_camera()))) {
        state.SkipWithError("configuration refused");
        return;
    }
    const auto grid = std::make_unique<OccupancyGrid>();
    int k = 0;
    for (auto _ : state) {
        state.PauseTiming();
        const auto view = flight.view(k++ % 200);
        mesher->update(*view, {});
        state.ResumeTiming();
        grid->update(*view, mesher->mesh(), static_cast<std::uint32_t>(mesher->counters().updates));
    }
}
BENCHMARK(grid_update)->Unit(benchmark::kMicrosecond);

void grid_sweep(benchmark::State& state) {
    const test::WallFlight flight;
    const auto mesher = std::make_unique<Mesher>();
    const auto grid = std::make_unique<OccupancyGrid>();
    if (!ok(mesher->configure({}, test::mesh_camera()))) {
        state.SkipWithError("configuration refused");
        return;
    }
    for (int k = 0; k < 20; ++k) {
        const auto view = flight.view(k);
        mesher->update(*view, {});
        grid->update(*view, mesher->mesh(), static_cast<std::uint32_t>(mesher->counters().updates));
    }
    std::array<GridSector, kSweepSectors> sectors;
    for (auto _ : state) {
        grid->sweep({.p_W = {0.0, 2.85, 0.0}}, sectors);
        benchmark::DoNotOptimize(sectors);
    }
}
BENCHMARK(grid_sweep)->Unit(benchmark::kMicrosecond);

}  // namespace
