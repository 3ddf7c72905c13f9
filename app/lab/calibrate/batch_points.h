// SPDX-License-Identifier: BSD-2-Clause
// The points of a batch: where the keyframes' states and the calibration put them.
#pragma once

#include <cstdint>
#include <vector>

#include "app/lab/calibrate/recorded_flight.h"
#include "app/lab/calibrate/rig_parameters.h"

namespace facet {

/// One image of a point.
struct BatchSighting {
    int keyframe = 0;
    int point = 0;   ///< index into BatchPoints::p_W
    int camera = 0;  ///< 0 left, 1 right
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
};

struct BatchPoints {
    std::vector<Eigen::Vector3d> p_W;
    std::vector<BatchSighting> sightings;  ///< by point
};

/// Points seen by at least three keyframes, with enough parallax, in front of all their cameras and within a few pixels
/// of where they were seen; at most kMaxBatchPoints, those with the most sightings. The point nearest to the lines of
/// sight d_i from the cameras' centres c_i: sum (I - d_i d_i^T) (p - c_i) = 0. Reentrant. Heap.
BatchPoints triangulate_points(const RecordedFlight& flight, const RigAndTime& rig);

/// Bounds the time: about 20 s of flight have this many points.
inline constexpr std::size_t kMaxBatchPoints = 6000;

}  // namespace facet
