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
    explicit CarriedEstimate(const ProgramConfig& config, double smoothing_s = 0.0) : imu_model_(config.imu_model) {
        carrier_.configure(config.imu_noise, config.imu_limits, config.gravity.norm_m_per_s2(), smoothing_s);
    }

    /// Takes a sample. @return false if there is no estimate at its stamp: it is refused, or there has been no start
    bool add_imu(const ImuSample& sample) {
        return ok(carrier_.add_imu(imu_model_.corrected(sample))) && carrier_.has_state();
    }

    /// Takes what the pipeline made of a frame, or what it says while none comes. Of a refused frame only the health
    /// counts; while LOST the last finite belief is carried on.
    /// @param belief  the pipeline's
    void correct(Status status, const Estimate& estimate, const Belief& belief);

    /// At the newest sample, its health that of the newest frame. After add_imu() has returned true.
    Estimate estimate() const;
    const Health& health() const { return newest_.health; }

private:
    ImuModel imu_model_;
    StateCarrier carrier_;
    Estimate newest_;  ///< of the newest frame
    /// What the reported covariance has beyond that of the belief: place and yaw when the window began.
    Eigen::Matrix<double, 9, 9> gauge_ = Eigen::Matrix<double, 9, 9>::Zero();
};

}  // namespace facet
