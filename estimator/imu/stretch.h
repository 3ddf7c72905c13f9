// SPDX-License-Identifier: BSD-2-Clause
// Statistics of a stretch of inertial samples, for judging rest and motion.
#pragma once

#include <Eigen/Core>

#include "estimator/imu/imu_buffer.h"

namespace facet {

/// Over the samples after the beginning of a stretch up to its end. Vectors: one number an axis.
struct StretchStatistics {
    int samples = 0;
    bool is_whole = true;  ///< no gap and no clipped reading in it
    Eigen::Vector3d mean_w_B = Eigen::Vector3d::Zero();
    Eigen::Vector3d mean_a_B = Eigen::Vector3d::Zero();
    Eigen::Vector3d gyro_std = Eigen::Vector3d::Zero();   ///< about the mean (rad/s)
    Eigen::Vector3d accel_std = Eigen::Vector3d::Zero();  ///< (m/s^2)
    /// Deviation of white noise with the same squared steps from sample to sample ([Neumann41]): unlike the above, slow
    /// changes do not raise it.
    Eigen::Vector3d gyro_step_std = Eigen::Vector3d::Zero();
    Eigen::Vector3d accel_step_std = Eigen::Vector3d::Zero();
    Eigen::Vector3d gyro_drift = Eigen::Vector3d::Zero();  ///< mean of the later half minus mean of the earlier (rad/s)
    Eigen::Vector3d accel_drift = Eigen::Vector3d::Zero();  ///< (m/s^2)

    /// Deviation of a drift if all there is is white noise of step deviation `step_std`.
    double drift_sigma(double step_std) const;
    /// Largest share of its limit that a drift has, over all axes: a limit is 4 such deviations of the axis and the
    /// allowance. Above 1 the stretch is no rest: the motion changes within it.
    double drift_share(double gyro_allowance, double accel_allowance) const;
};

/// [Neumann41] The Mean Square Successive Difference, Annals of Mathematical Statistics 1941.
/// @return kNotReady with less than 4 samples; else as ImuBuffer::for_each_step (out untouched). Reentrant. No heap.
Status stretch_statistics(const ImuBuffer& buffer, Timestamp begin, Timestamp end, StretchStatistics& out);

}  // namespace facet
