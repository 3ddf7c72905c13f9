// SPDX-License-Identifier: BSD-2-Clause
// Inertial factors between the keyframes of a recorded flight.
#pragma once

#include <vector>

#include "app/lab/calibrate/recorded_flight.h"
#include "estimator/factors/imu_factor.h"
#include "estimator/imu/imu_limits.h"
#include "estimator/values/gravity.h"

namespace facet {

/// Factor k connects keyframes k and k + 1, its samples integrated at the bias of keyframe k; clipping, gaps and
/// vibration count as in flight (estimator/imu/imu_buffer.h).
struct InertialChain {
    std::vector<ImuFactor> factors;
    std::vector<Eigen::Vector3d> w_B;  ///< angular rate at each keyframe, less its bias (rad/s)
};

/// @return the error of the interval that could not be integrated: no samples, or too long (out untouched). Heap.
Status integrate_chain(const RecordedFlight& flight, const ImuNoise& noise, const ImuLimits& limits,
                       const GravityConfig& gravity, InertialChain& out);

}  // namespace facet
