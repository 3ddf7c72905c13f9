// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/vibration_share.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr double kMemoryS = 10.0;
constexpr double kPriorInformation = 1.0 / (2.0 * 2.0);
constexpr double kMostOfExpected = 4.0;
// Share of 1/400 to 2: below, the sensor's own noise rules; above, a meter that saw less than there is.
constexpr double kLeast = -6.0;
constexpr double kMost = 0.7;

}  // namespace

template <int kRows>
void VibrationLearner::Logarithm::learn(const Eigen::Matrix<double, kRows, 1>& r,
                                        const Eigen::Matrix<double, kRows, kRows>& m, const InertialInnovation& of) {
    const double expected = m.trace();
    if (!(expected > 0.0) || !r.allFinite()) {
        return;
    }
    information = information * std::exp(-of.dt_s / kMemoryS) + 0.5 * m.squaredNorm();
    const double score = 0.5 * (std::min(r.squaredNorm(), kMostOfExpected * expected) - expected);
    x = std::clamp(x + score / (kPriorInformation + information), kLeast, kMost);
}

void VibrationLearner::learn_gyro(const InertialInnovation& innovation) {
    gyro_.learn<3>(innovation.r.head<3>(), innovation.covariance.topLeftCorner<3, 3>(), innovation);
}

void VibrationLearner::learn_accel(const InertialInnovation& innovation) {
    accel_.learn<6>(innovation.r.tail<6>(), innovation.covariance.bottomRightCorner<6, 6>(), innovation);
}

VibrationShare VibrationLearner::share() const { return {std::exp(gyro_.x), std::exp(accel_.x)}; }

}  // namespace facet
