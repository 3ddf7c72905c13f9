// SPDX-License-Identifier: BSD-2-Clause
// An estimate by the conventions of ROS (REP 103, REP 105).
#pragma once

#include "drivers/ros2/ros2_messages.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// World and body have ROS's axes already (x forward, y left, z up); what differs is what covariances and velocities
/// are relative to: turns are about the axes of the odometry's frame, R cov R^T, and the twist is in the body's, R^T v
/// with R^T cov R. That R itself is uncertain is left out of the twist's covariance. Reentrant. No heap.
/// @param stamp  of the estimate, CLOCK_REALTIME
Ros2Odometry to_ros2(const Odometry& odometry, Timestamp stamp);

/// Whether every number is finite and every variance positive. Reentrant. No heap.
bool is_publishable(const Odometry& odometry);

}  // namespace facet
