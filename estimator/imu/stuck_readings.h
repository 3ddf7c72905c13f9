// SPDX-License-Identifier: BSD-2-Clause
// Whether a sensor gives the same reading again and again.
#pragma once

#include "estimator/imu/imu_axes.h"
#include "platform/base/samples.h"

namespace facet {

/// A sensor hangs if all three of its axes repeat to the bit for longer than they do while it lives. Noise of half a
/// digit's deviation already leaves an axis alike in half of the samples, all three in an eighth, and so twenty times
/// in a row once in 10^18 samples. A sensor that repeats more, because it is coarse, gives each reading several times
/// or is simulated without noise, is known by the longest run that it has shown so far: of N runs of geometric lengths
/// one of kTimes the longest length has a probability of N^-kTimes.
///
/// That alone proves nothing, a simulation may hover: it is for who has another reason to doubt them. The runs of
/// readings that are suspected are not learnt from. Thread-bound. No heap.
class StuckReadings {
public:
    static constexpr int kLeastRepeats = 20;
    static constexpr double kLeastTime_s = 0.05;
    static constexpr int kTimes = 4;

    explicit StuckReadings(double rate_hz = 200.0);

    /// The next sample follows no other; what was learnt stays.
    void restart();

    /// Takes in a sample as read. @param clipped  its axes at their range, which repeat with every reason
    /// @return axes of the sensors that are stuck
    ImuAxisMask add(const ImuSample& sample, ImuAxisMask clipped);

    /// These axes' present runs are not to be learnt from, the others' are.
    void distrust(ImuAxisMask axes);

private:
    struct Run {
        int repeats = 0;
        int longest = 0;  ///< of earlier ones that were believed
        bool is_distrusted = false;
    };

    bool follow(bool repeats, Run& run) const;

    int least_ = 0;  ///< repeats
    bool has_last_ = false;
    ImuSample last_;
    Run gyro_;
    Run accel_;
};

}  // namespace facet
