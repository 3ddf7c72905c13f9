// SPDX-License-Identifier: BSD-2-Clause
// Predictions that are known beforehand, for tests of the front-end.
#pragma once

#include "estimator/frontend/frontend_types.h"

namespace facet::test {

/// The predictions must outlive it.
class GivenLandmarks final : public LandmarkSource {
public:
    explicit GivenLandmarks(std::span<const LandmarkPrediction> landmarks) : landmarks_(landmarks) {}
    std::span<const LandmarkPrediction> predict() override { return landmarks_; }

private:
    std::span<const LandmarkPrediction> landmarks_;
};

}  // namespace facet::test
