// SPDX-License-Identifier: BSD-2-Clause
// Removes observations that contradict the optimized poses from the window.
#pragma once

#include <boost/container/static_vector.hpp>

#include "estimator/window/window_cameras.h"

namespace facet {

struct OutlierCount {
    int observations = 0;  ///< left or right measurements removed
    int landmarks = 0;     ///< landmarks left without enough observations and removed
};

/// Removes every measurement of an active landmark that lies farther from its reprojection than the threshold. A
/// landmark that lost a measurement and is left with fewer than two keyframes is removed. Observations of keyframes
/// inside the prior are removable as well: the prior does not contain them.
/// @param threshold_px  reprojection distance (px)
/// @param rejected      receives the landmarks whose newest observation was removed, or which were removed themselves;
///                      when full, the rest is left to the next keyframe
OutlierCount remove_outliers(double threshold_px, WindowState& state, const WindowCameras& cameras,
                             boost::container::static_vector<LandmarkId, kMaxFeatures>& rejected);

}  // namespace facet
