// SPDX-License-Identifier: BSD-2-Clause
// Detects keyframes without new information: at rest and in hover they must not push older views out of the window.
#pragma once

#include <boost/container/static_vector.hpp>

#include "estimator/window/window_state.h"

namespace facet {

/// Compares a keyframe with the one before it by the landmarks they share. Thread-bound. No heap.
class RedundancyTest {
public:
    /// True if keyframe k >= 1 sees mostly landmarks that keyframe k - 1 sees as well, and the median of their movement
    /// between the two images, whatever its cause, is below the threshold.
    /// @param threshold  in normalised coordinates (-)
    bool is_redundant(const WindowState& state, int k, double threshold);

private:
    boost::container::static_vector<double, kMaxFeatures> movement_;
};

}  // namespace facet
