// SPDX-License-Identifier: BSD-2-Clause
// Distances all around the vehicle, from the mesh over the horizon.
#pragma once

#include <memory>

#include "app/config/obstacle_options.h"
#include "estimator/api/estimate.h"
#include "mesh/range_query.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// Sweeps the mesh about the newest estimate. What the mesh has no face in is unknown: RangeQuery cannot tell free
/// space from space that was never seen, from surfaces without texture, or from faces that the filters rejected. A
/// distance is that of the nearest known face; something unknown may be nearer. Thread-bound. Heap in the constructor.
class ObstacleSweep {
public:
    explicit ObstacleSweep(const ObstacleOptions& options)
        : options_(options), query_(std::make_unique<RangeQuery>()) {}

    /// To be called when the mesh has changed. No heap.
    void update(const HorizonMesh& mesh) { query_->update(mesh); }
    /// @return whether a sweep was due: ranges are untouched otherwise. No heap.
    bool sweep(const Estimate& estimate, ObstacleRanges& ranges);

private:
    ObstacleOptions options_;
    std::unique_ptr<RangeQuery> query_;
    bool any_ = false;
    Timestamp last_;
};

}  // namespace facet
