// SPDX-License-Identifier: BSD-2-Clause
// Distances all around the vehicle, from the grid and the mesh over the horizon.
#pragma once

#include <memory>

#include "app/config/obstacle_options.h"
#include "estimator/api/estimate.h"
#include "mesh/occupancy_grid.h"
#include "mesh/range_query.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// Sweeps grid and mesh about the newest estimate. A distance is that of the nearest occupied cell of the grid, or of a
/// face of the mesh, which reaches farther, if that is nearer; something unknown may be nearer still. A sector is free
/// only if the grid knows it to be free up to the full range. All else is unknown, as is everything without a face if
/// there is no grid: a mesh cannot tell free space from space never seen, or from surfaces without texture. A face in
/// space that the grid knows to be free by now is left out. Thread-bound. Heap in the constructor.
class ObstacleSweep {
public:
    /// @param T_body_imu  from the estimator's body to the one whose x axis and place count
    explicit ObstacleSweep(const ObstacleOptions& options, const Se3& T_body_imu = {})
        : options_(options), T_imu_body_(T_body_imu.inverse()), query_(std::make_unique<RangeQuery>()) {}

    /// To be called when the mesh has changed. No heap.
    void update(const HorizonMesh& mesh) { query_->update(mesh); }
    /// @return whether a sweep was due: ranges are untouched otherwise. No heap.
    /// @param grid  null: there is none
    bool sweep(const Estimate& estimate, const OccupancyGrid* grid, ObstacleRanges& ranges);

private:
    ObstacleOptions options_;
    Se3 T_imu_body_;
    std::unique_ptr<RangeQuery> query_;
    bool any_ = false;
    Timestamp last_;
};

}  // namespace facet
