// SPDX-License-Identifier: BSD-2-Clause
// The calibrated sensor set of a vehicle: two cameras and one IMU.
#pragma once

#include "estimator/geometry/camera_model.h"
#include "estimator/geometry/se3.h"

namespace facet {

/// Two cameras rigidly mounted to the body (= IMU) frame. Immutable during a run.
struct StereoRig {
    CameraModel left;
    CameraModel right;
    Se3 T_B_C0;  ///< left camera to body
    Se3 T_B_C1;  ///< right camera to body

    /// Right from left: p_C1 = T_C1_C0 * p_C0.
    Se3 T_C1_C0() const { return T_B_C1.inverse() * T_B_C0; }
    double baseline_m() const { return (T_B_C1.p - T_B_C0.p).norm(); }
};

/// Continuous-time noise of the IMU, white noise and bias random walk.
struct ImuNoise {
    double gyro_noise_rad_per_s_per_sqrt_hz = 1.7e-4;
    double gyro_walk_rad_per_s2_per_sqrt_hz = 2.0e-5;
    double accel_noise_m_per_s2_per_sqrt_hz = 2.0e-3;
    double accel_walk_m_per_s3_per_sqrt_hz = 3.0e-3;
    double rate_hz = 200.0;
};

}  // namespace facet
