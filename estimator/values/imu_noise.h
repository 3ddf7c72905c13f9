// SPDX-License-Identifier: BSD-2-Clause
// How noisy the IMU is, as its calibration says.
#pragma once

namespace facet {

/// Continuous-time noise of the IMU, white noise and bias random walk.
struct ImuNoise {
    double gyro_noise_rad_per_s_per_sqrt_hz = 1.7e-4;
    double gyro_walk_rad_per_s2_per_sqrt_hz = 2.0e-5;
    double accel_noise_m_per_s2_per_sqrt_hz = 2.0e-3;
    double accel_walk_m_per_s3_per_sqrt_hz = 3.0e-3;
    double rate_hz = 200.0;
};

}  // namespace facet
