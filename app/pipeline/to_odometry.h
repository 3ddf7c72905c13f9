// SPDX-License-Identifier: BSD-2-Clause
// Estimates as the consumers of odometry take them.
#pragma once

#include "estimator/api/estimate.h"
#include "estimator/values/health.h"
#include "estimator/values/imu_noise.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// The variance of the angular rate is that of the sensor's noise at its bandwidth. The quality of a lost estimator is
/// -1. Reentrant. No heap.
/// @param w_B  angular rate as measured
Odometry to_odometry(const Estimate& estimate, const Eigen::Vector3d& w_B, const ImuNoise& noise);

/// The estimator's state in words, such as "facet: DEGRADED few_features|vibration". Reentrant. Heap.
StateChange describe_state(TrackingState state, std::uint32_t reasons);

}  // namespace facet
