// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/stuck_readings.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

// Longer runs count as this long, so that their multiple is an int.
constexpr int kMostRepeats = 1 << 24;

}  // namespace

StuckReadings::StuckReadings(double rate_hz)
    : least_(std::max(kLeastRepeats, static_cast<int>(std::ceil(kLeastTime_s * rate_hz)))) {}

void StuckReadings::restart() {
    has_last_ = false;
    gyro_.repeats = accel_.repeats = 0;
    distrust(0);
}

ImuAxisMask StuckReadings::add(const ImuSample& sample, ImuAxisMask clipped) {
    const bool has_gyro = has_last_ && (clipped & kGyroAxes) == 0;
    const bool has_accel = has_last_ && (clipped & kAccelAxes) == 0;
    const bool is_gyro = follow(has_gyro && sample.w_B == last_.w_B, gyro_);
    const bool is_accel = follow(has_accel && sample.a_B == last_.a_B, accel_);
    has_last_ = true;
    last_ = sample;
    return static_cast<ImuAxisMask>((is_gyro ? kGyroAxes : 0) | (is_accel ? kAccelAxes : 0));
}

void StuckReadings::distrust(ImuAxisMask axes) {
    gyro_.is_distrusted = (axes & kGyroAxes) != 0;
    accel_.is_distrusted = (axes & kAccelAxes) != 0;
}

bool StuckReadings::follow(bool repeats, Run& run) const {
    if (repeats) {
        run.repeats = std::min(run.repeats + 1, kMostRepeats);
    } else {
        run.longest = run.is_distrusted ? run.longest : std::max(run.longest, run.repeats);
        run.repeats = 0;
        run.is_distrusted = false;
    }
    return run.repeats >= std::max(least_, kTimes * run.longest);
}

}  // namespace facet
