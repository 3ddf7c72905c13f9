// SPDX-License-Identifier: BSD-2-Clause
// What a faulty IMU reads.
#pragma once

#include <cstdint>
#include <map>

#include "app/lab/faults/fault_schedule.h"
#include "app/lab/faults/fault_vibration.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/imu_scale.h"
#include "estimator/values/nav_state.h"
#include "platform/base/samples.h"

namespace facet {

/// Changes readings as the faults ask, in this order: axes, noise; vibration, scale and bias, which an IMU has before
/// the first frame too; full scale, frozen, zero, NaN. Deterministic: noise depends on the number of the sample only.
/// Thread-bound. Heap in the constructor and when a fault begins.
class InertialFaults {
public:
    /// @param noise  calibrated densities, for imu_noise
    InertialFaults(FaultSchedule& schedule, const ImuNoise& noise);

    /// @param number  of the sample in the log, from 1
    void change(ImuSample& sample, std::uint64_t number);

private:
    void turn_axes(ImuSample& sample);
    void add_noise(ImuSample& sample, std::uint64_t number);
    void shake_and_bias(ImuSample& sample, std::uint64_t number);
    void walk(const Fault& fault, std::size_t index, std::uint64_t number);
    void clip(ImuSample& sample);
    void freeze(ImuSample& sample);
    void lose_values(ImuSample& sample, std::uint64_t number);

    FaultSchedule& schedule_;
    ImuNoise noise_;
    std::map<std::size_t, FaultVibration> vibrations_;  ///< by fault
    std::map<std::size_t, ImuBias> biases_;             ///< by fault
    std::map<std::size_t, ImuScale> scales_;            ///< errors, by fault
    std::map<std::size_t, ImuSample> frozen_;           ///< the first sample of the time, by fault
};

}  // namespace facet
