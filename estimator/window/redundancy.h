// SPDX-License-Identifier: BSD-2-Clause
// Tells which keyframes say nothing new: standing still and hovering must not push older views out of the window.
#pragma once

#include <boost/container/static_vector.hpp>

#include "estimator/window/window_state.h"

namespace facet {

/// Judges a keyframe by the landmarks it shares with the one before it. Thread-bound. No heap.
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
