// SPDX-License-Identifier: BSD-2-Clause
// The newest estimate at every inertial sample.
#pragma once

#include "app/config/program_config.h"
#include "app/pipeline/frame_pipeline.h"
#include "estimator/api/state_carrier.h"

namespace facet {

/// Carries a pipeline's estimates on to inertial samples: all samples come here, as soon as they are known, and every
/// frame's result. Thread-bound. About 560 kB: on the heap or static. No heap itself.
class CarriedEstimate {
public:
    explicit CarriedEstimate(const ProgramConfig& config) {
        carrier_.configure(config.imu_noise, config.imu_limits, config.gravity.norm_m_per_s2());
    }

    /// Takes a sample. @param estimate  at its stamp, its health that of the newest frame
    /// @return false if there is none: the sample is refused, or the newest frame has no estimate that can be used
    bool add_imu(const ImuSample& sample, Estimate& estimate);

    /// Takes what the pipeline made of a frame.
    void correct(const FrameResult& result, const Belief& belief);

private:
    StateCarrier carrier_;
    Estimate newest_;  ///< of the newest frame
};

}  // namespace facet
