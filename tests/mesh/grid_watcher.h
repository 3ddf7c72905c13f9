// SPDX-License-Identifier: BSD-2-Clause
// A mesher with the grid behind it, which sees made-up walls.
#pragma once

#include <memory>

#include "mesh/occupancy_grid.h"
#include "tests/mesh/mesh_world.h"
#include "tests/support/allocation_guard.h"

namespace facet::test {

/// A wall across the x axis.
inline MeshWorld wall_at(double x) {
    MeshWorld world;
    world.wall(1.6, 1.0, 0.25, [=](double, double) { return x; });
    return world;
}

struct GridWatcher {
    std::unique_ptr<Mesher> mesher;
    std::unique_ptr<OccupancyGrid> grid = std::make_unique<OccupancyGrid>();

    GridWatcher() { mesher = make_mesher(); }

    /// A keyframe at this second; the grid takes no memory for it.
    void see(KeyframeView& view, double second) {
        view.stamp = Timestamp{} + Duration::from_seconds(second);
        view.oldest_stamp = {0};
        mesher->update(view, {});
        const AllocationGuard guard;
        grid->update(view, mesher->mesh(), static_cast<std::uint32_t>(mesher->counters().updates));
        CHECK(guard.allocations() == 0);
    }
    void see(const MeshWorld& world, const Se3& T_W_C0, double second) {
        see(*view_of(world, T_W_C0, static_cast<int>(second)), second);
    }
};

}  // namespace facet::test
