// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/calibration_quality.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr double kAsStated = 1.0;  // parameters that are believed to be as good as stated
constexpr double kMostScale = 5.0;

}  // namespace

void CalibrationQuality::reset(const CalibrationMatrix& given) {
    FACET_ASSERT(given.rows() >= kRigDim + kCameraTermsDim);
    const Covariance cameras = given.block<kCameraTermsDim, kCameraTermsDim>(kRigDim, kRigDim);
    given_information_ = Eigen::LLT<Covariance>(cameras).solve(Covariance::Identity());
    squared_scale_ = 1.0;
}

void CalibrationQuality::learn(const Correction& correction, const Covariance& covariance) {
    const double seen =
        correction.dot(given_information_ * correction) + given_information_.cwiseProduct(covariance).sum();
    if (std::isfinite(seen) && seen >= 0.0) {
        constexpr double kMost = kMostScale * kMostScale;
        squared_scale_ = std::clamp((kAsStated + seen) / (kAsStated + kCameraTermsDim), 1.0 / kMost, kMost);
    }
}

double CalibrationQuality::scale() const { return std::sqrt(squared_scale_); }

CalibrationMatrix CalibrationQuality::scaled(const CalibrationMatrix& information, int first) const {
    CalibrationMatrix out = information;
    const int end = std::min(static_cast<int>(out.rows()), kImuScale);
    if (end > first) {
        out.block(first, 0, end - first, end) /= scale();
        out.block(0, first, end, end - first) /= scale();
    }
    return out;
}

}  // namespace facet
