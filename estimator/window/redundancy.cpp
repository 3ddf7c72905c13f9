// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/redundancy.h"

#include <algorithm>

namespace facet {
namespace {

constexpr double kMostlyShared = 0.6;
constexpr std::size_t kFewestShared = 20;

}  // namespace

bool RedundancyTest::is_redundant(const WindowState& state, int k, double threshold) {
    movement_.clear();
    int seen = 0;
    for (int i = 0; i < state.landmarks.size(); ++i) {
        const auto& observations = state.landmarks[i].observations;
        const auto at =
            std::lower_bound(observations.begin(), observations.end(), k,
                             [](const LandmarkObservation& o, int keyframe) { return o.keyframe < keyframe; });
        if (at == observations.end() || at->keyframe != k) {
            continue;
        }
        ++seen;
        if (at != observations.begin() && (at - 1)->keyframe == k - 1 && movement_.size() < movement_.capacity()) {
            movement_.push_back((at->measurement.left_xy - (at - 1)->measurement.left_xy).norm());
        }
    }
    if (movement_.size() < kFewestShared || static_cast<double>(movement_.size()) < kMostlyShared * seen) {
        return false;
    }
    const auto middle = movement_.begin() + static_cast<std::ptrdiff_t>(movement_.size() / 2);
    std::nth_element(movement_.begin(), middle, movement_.end());
    return *middle < threshold;
}

}  // namespace facet
