// SPDX-License-Identifier: BSD-2-Clause
// The first state and its prior, from a short stretch of inertial samples: standing still or already moving.
#pragma once

#include <Eigen/Core>

#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/initializer_config.h"
#include "estimator/imu/preintegration.h"
#include "estimator/values/nav_state.h"
#include "platform/base/status.h"

namespace facet {

/// A first state with its prior, tangent order [theta p v bg ba].
struct InitialState {
    NavState state;
    /// W of the prior |W d|^2 with d = state.box_minus_to(x): diagonal but for the rotation, whose block is
    /// diag(1 / tilt, 1 / tilt, 1 / yaw) R_W_B, because tilt and yaw are errors about the axes of W and theta is in B,
    /// and at rest for what ties the tilt to the accelerometer's bias.
    Eigen::Matrix<double, 15, 15> sqrt_information = Eigen::Matrix<double, 15, 15>::Zero();
    bool is_still = false;
    double tilt_sigma_rad = 0.0;  ///< of the gravity direction, each horizontal axis of W

    /// W^T W.
    Eigen::Matrix<double, 15, 15> information() const { return sqrt_information.transpose() * sqrt_information; }
};

/// Attitude with W z along up_B (unit) and yaw zero as below. Reentrant. No heap.
Eigen::Quaterniond level_attitude(const Eigen::Vector3d& up_B);

/// State at a frame's stamp from the samples of up to kMaxDuration_s before it that follow the last gap or clipped
/// reading.
///
/// Frame: the origin of W is the body at this stamp, W z is opposite to gravity, and the yaw is zero: the body x axis,
/// projected on the horizontal plane, points along W x. If the body x axis is within 5.7 degrees of the vertical, the
/// body z axis takes its place. Position and yaw get sigmas of 1e-4 m and 1e-4 rad: they are a choice, not an estimate.
///
/// Still, if the standard deviations of gyroscope and accelerometer, the mean rate and | |mean force| - g | are all
/// below the config's limits, and the later half of the stretch differs from the earlier one by no more than noise and
/// a small allowance (0.03 m/s^2, 0.01 rad/s), which detects the beginning of a take-off. Then: zero velocity, gyro
/// bias = mean rate, accelerometer bias along gravity = |mean force| - g. Along the horizontal only the sum of gravity
/// and bias is measured: an error d_theta of the attitude and one d_b of the bias have to leave
/// g e_z x (R_W_B d_theta) + R_W_B d_b zero but for still_accel_sigma. Each by itself is known as well as the bias is.
/// Moving, otherwise: forces are rotated into the last body frame with the gyroscope before they are averaged; velocity
/// and biases are zero with wide sigmas; the tilt sigma grows with the spread of the forces' direction over tenths of
/// the stretch, the error of their magnitude, and the rotation of the mean by the unknown gyro bias; it is at least
/// kMovingTiltSigma_rad.
///
/// @param stamp             of the first frame
/// @param gravity_m_per_s2  its strength, g above
/// @param may_rest          false: images show motion, whatever the samples look like
/// @param out               written on kOk only
/// @return kNotReady if samples do not reach the stamp, or cover less than kMinDuration_s before it without gaps and
///         clipping; kDegenerate if the mean force is below 1 m/s^2 (free fall). Reentrant. No heap.
Status initialize_state(const ImuBuffer& buffer, Timestamp stamp, double gravity_m_per_s2,
                        const InitializerConfig& config, InitialState& out, bool may_rest = true);

/// A time in which images have shown rest.
struct RestStretch {
    Timestamp begin;
    Timestamp end;
};

/// State at the end of a rest that images have shown, however much rotors shake the IMU: as at rest above, from tapered
/// means. Their variances are those of stretch.h times the share of the vibration that the window's inertial factors
/// begin with (vibration_share.h), for neither takes its spectrum to be flat down to zero. Deviations and drift of the
/// samples are not judged.
/// @return kDegenerate if the mean rate or force is not that of a rest; else as tapered_means() (out untouched).
///         Reentrant. No heap.
Status initialize_shaken(const ImuBuffer& buffer, const RestStretch& rest, double gravity_m_per_s2,
                         const InitializerConfig& config, InitialState& out);

}  // namespace facet
