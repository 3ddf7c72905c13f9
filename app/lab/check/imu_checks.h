// SPDX-License-Identifier: BSD-2-Clause
// Checks of the inertial samples by themselves: rate, gravity, noise.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "app/lab/check/verdict.h"
#include "estimator/values/imu_noise.h"
#include "platform/base/samples.h"

namespace facet {

/// Samples [begin, end) of a stretch at rest.
struct RestStretch {
    std::size_t begin = 0;
    std::size_t end = 0;
};

/// Stretches of one second in which neither sensor's mean over a tenth of a second moves by more than 0.02 rad/s and
/// 0.15 m/s^2: a vehicle at rest, rotors running or not. Nothing is assumed about units of the accelerometer beyond
/// that a hovering vehicle moves more. Reentrant. Heap.
std::vector<RestStretch> find_rests(std::span<const ImuSample> samples);

/// The median step between samples against the file's rate: within 5 % ok, within 30 % suspicious.
CheckVerdict check_imu_rate(std::span<const ImuSample> samples, const ImuNoise& noise);

/// Magnitude of the accelerometer: of its mean over the stretches at rest, else the mean magnitude over the log, which
/// motion makes a little larger. Names readings in g and readings without gravity.
CheckVerdict check_gravity(std::span<const ImuSample> samples, std::span<const RestStretch> rests);

/// White noise at rest, from differences of consecutive samples, as densities against the file's: up to 3 times is ok,
/// up to 10 times suspicious. Cannot tell without a stretch at rest: motion and vibration would count as noise.
CheckVerdict check_imu_noise(std::span<const ImuSample> samples, std::span<const RestStretch> rests,
                             const ImuNoise& noise);

}  // namespace facet
