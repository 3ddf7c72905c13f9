// SPDX-License-Identifier: BSD-2-Clause
// Statistics of a stretch of inertial samples, for judging rest and motion.
#pragma once

#include <Eigen/Core>

#include "estimator/imu/imu_buffer.h"

namespace facet {

/// Over the samples after the beginning of a stretch up to its end. Vectors: one value per axis.
struct StretchStatistics {
    int samples = 0;
    bool is_whole = true;  ///< no gap and no clipped reading in it
    Eigen::Vector3d mean_w_B = Eigen::Vector3d::Zero();
    Eigen::Vector3d mean_a_B = Eigen::Vector3d::Zero();
    Eigen::Vector3d gyro_std = Eigen::Vector3d::Zero();   ///< about the mean (rad/s)
    Eigen::Vector3d accel_std = Eigen::Vector3d::Zero();  ///< (m/s^2)
    /// Deviation of white noise with the same squared differences from sample to sample ([Neumann41]): unlike the
    /// above, it is not raised by slow changes.
    Eigen::Vector3d gyro_step_std = Eigen::Vector3d::Zero();
    Eigen::Vector3d accel_step_std = Eigen::Vector3d::Zero();
    Eigen::Vector3d gyro_drift = Eigen::Vector3d::Zero();  ///< mean of the later half minus mean of the earlier (rad/s)
    Eigen::Vector3d accel_drift = Eigen::Vector3d::Zero();  ///< (m/s^2)

    /// Deviation of a drift that is caused only by white noise of step deviation `step_std`.
    double drift_sigma(double step_std) const;
    /// Largest share of its limit that a drift reaches, over all axes: a limit is 4 such deviations of the axis plus
    /// the allowance. Above 1 the stretch is not a rest: the motion changes within it.
    double drift_share(double gyro_allowance, double accel_allowance) const;
};

/// Means of a stretch that is shaken, and their standard deviations: one value per axis.
struct TaperedMeans {
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();
    Eigen::Vector3d a_B = Eigen::Vector3d::Zero();
    Eigen::Vector3d w_sigma = Eigen::Vector3d::Zero();
    Eigen::Vector3d a_sigma = Eigen::Vector3d::Zero();
};

/// Weighted by Hann's window h(t) = 1 - cos(2 pi t / T), which leaves next to nothing of what shakes faster than 2 / T:
/// a plain mean keeps A / (pi f T) of a tone. The deviations are those that a spectrum gives to the mean which is flat
/// from zero to 3 / T, as high as the stretch has it at 2 / T and 3 / T, where the window hides the mean:
///   sigma^2 = 1/2 sum_m |sum_k h_k x_k exp(2 pi i m t_k / T)|^2 / (sum_k h_k)^2,    m = 2, 3
/// which is right for white noise and cautious for shaking, whose spectrum falls towards zero.
/// [Harris78] On the Use of Windows for Harmonic Analysis with the Discrete Fourier Transform, Proc. IEEE 1978.
/// @return kNotReady with fewer than 16 samples; kDegenerate with a gap or a clipped reading in the stretch; else as
///         ImuBuffer::for_each_step (out untouched). Reentrant. No heap.
Status tapered_means(const ImuBuffer& buffer, Timestamp begin, Timestamp end, TaperedMeans& out);

/// [Neumann41] The Mean Square Successive Difference, Annals of Mathematical Statistics 1941.
/// @return kNotReady with fewer than 4 samples; else as ImuBuffer::for_each_step (out untouched). Reentrant. No heap.
Status stretch_statistics(const ImuBuffer& buffer, Timestamp begin, Timestamp end, StretchStatistics& out);

}  // namespace facet
