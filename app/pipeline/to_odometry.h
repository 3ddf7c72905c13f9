// SPDX-License-Identifier: BSD-2-Clause
// Estimates as the consumers of odometry take them.
#pragma once

#include "estimator/api/estimate.h"
#include "estimator/geometry/se3.h"
#include "estimator/values/health.h"
#include "estimator/values/imu_noise.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// The variance of the angular rate is that of the sensor's noise at its bandwidth. The quality of a lost estimator is
/// -1. The estimator's body B is the IMU. Consumers may want another frame V on the same rigid body, level with the
/// vehicle and at its centre, under the name of B in Odometry:
///   q_W_V = q_W_B q_B_V,  p_W_V = p_W_B + R r,  v_W_V = v_W_B + R (w x r),  w_V = R_V_B w,  with r = p_B_V
/// and the uncertainty carried over to first order, with [r]x the matrix of the cross product:
///   theta_V = R_V_B theta,  p_V = p - R [r]x theta,  v_V = v - R [w x r]x theta - R [r]x dw
/// where dw is the error of w: that of the sensor's noise, as in w_covariance. W stays as it is: its origin is the
/// first place of the IMU, its yaw that of the IMU's axes. Reentrant. No heap.
/// @param w_B         angular rate as measured
/// @param T_body_imu  T_V_B; the identity changes no bit
Odometry to_odometry(const Estimate& estimate, const Eigen::Vector3d& w_B, const ImuNoise& noise,
                     const Se3& T_body_imu = {});

/// The estimator's state in words, such as "facet: DEGRADED few_features|vibration". Reentrant. Heap.
StateChange describe_state(TrackingState state, std::uint32_t reasons);

}  // namespace facet
