// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/vibration.h"

#include <algorithm>
#include <cmath>

#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr double kAverageS = 0.25;
// Binomial smoothing [1 4 6 4 1] and [1 0 -2 0 1], one after the other.
constexpr std::array<double, 9> kMidTaps{1.0, 4.0, 4.0, -4.0, -10.0, -4.0, 4.0, 4.0, 1.0};
constexpr double kMidGain = 198.0;  // sum of squares
constexpr std::array<double, 5> kHighTaps{1.0, -4.0, 6.0, -4.0, 1.0};
constexpr double kHighGain = 70.0;

}  // namespace

void VibrationMeter::clear(double rate_hz) {
    FACET_ASSERT(rate_hz > 0.0);
    share_ = 1.0 - std::exp(-1.0 / (kAverageS * rate_hz));
    filled_ = 0;
    count_ = 0.0;
    high_.setZero();
    mid_.setZero();
    level_ = {};
}

void VibrationMeter::add(const ImuSample& sample) {
    std::copy_backward(last_.begin(), last_.end() - 1, last_.end());
    last_.front() << sample.w_B, sample.a_B;
    filled_ = std::min(filled_ + 1, kTaps);
    if (filled_ < kTaps) {
        return;
    }
    Axes high = Axes::Zero();
    Axes mid = Axes::Zero();
    for (std::size_t k = 0; k < kHighTaps.size(); ++k) {
        high += kHighTaps[k] * last_[k];
    }
    for (std::size_t k = 0; k < kMidTaps.size(); ++k) {
        mid += kMidTaps[k] * last_[k];
    }
    // The plain mean until there are enough squares for the exponential one.
    count_ += 1.0;
    const double share = std::max(share_, 1.0 / count_);
    high_ += share * (high.square() / kHighGain - high_);
    mid_ += share * (mid.square() / kMidGain - mid_);
    level_.high = high_.cast<float>();
    level_.mid = mid_.cast<float>();
}

Eigen::Vector3d VibrationMeter::edge_variances(const VibrationLevel& level, int first_axis, double share,
                                               double rate_hz) {
    const auto part = [first_axis](const VibrationLevel::Axes& power) -> Eigen::Vector3d {
        return power.segment<3>(first_axis).matrix().cast<double>();
    };
    const double left = kWhiteEdge * std::max(0.0, 1.0 - share);
    return (kEdge * part(level.tone()) + left * part(level.white()) + kRumbleEdge * part(level.rumble())) /
           (rate_hz * rate_hz);
}

}  // namespace facet
