// SPDX-License-Identifier: BSD-2-Clause
// The newest estimate at every inertial sample.
#pragma once

#include "app/config/program_config.h"
#include "estimator/api/estimate.h"
#include "estimator/api/state_carrier.h"

namespace facet {

/// Carries a pipeline's estimates on to inertial samples: all samples come here, as soon as they are known, and what
/// became of every frame. Thread-bound, but needs nothing of the pipeline: it may live in another thread. About 560 kB:
/// on the heap or static. No heap itself.
class CarriedEstimate {
public:
    /// @param smoothing_s  see StateCarrier; a reset is a step all the same
    explicit CarriedEstimate(const ProgramConfig& config, double smoothing_s = 0.0)
        : imu_model_(config.imu_model), imu_limits_(config.imu_limits) {
        carrier_.configure(config.imu_noise, config.imu_limits, config.gravity.magnitude_m_per_s2, smoothing_s);
    }

    /// Takes a sample. @return false if there is no estimate at its stamp: it is refused, or there has been no start
    bool add_imu(const ImuSample& sample) {
        newest_w_B_ = imu_model_.corrected(sample).w_B;
        return ok(carrier_.add_imu(imu_model_.corrected(sample), imu_limits_.clipped_axes(sample))) &&
               carrier_.has_state();
    }
    /// Of the newest sample, corrected by the IMU's model, its bias still in it (rad/s).
    const Eigen::Vector3d& newest_rate() const { return newest_w_B_; }

    /// Takes what the pipeline made of a frame, or what it says while none comes. Of a refused frame only the health
    /// counts; while LOST the last finite belief is carried on.
    /// @param belief  the pipeline's
    void correct(Status status, const Estimate& estimate, const Belief& belief);

    /// At the newest sample, its health that of the newest frame. After add_imu() has returned true.
    Estimate estimate() const;
    const Health& health() const { return newest_.health; }

private:
    ImuModel imu_model_;
    ImuLimits imu_limits_;
    Eigen::Vector3d newest_w_B_ = Eigen::Vector3d::Zero();
    StateCarrier carrier_;
    Estimate newest_;  ///< of the newest frame
    /// What the reported covariance has beyond that of the belief: position and yaw when the window began.
    Eigen::Matrix<double, 9, 9> gauge_ = Eigen::Matrix<double, 9, 9>::Zero();
};

}  // namespace facet
