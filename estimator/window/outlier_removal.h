// SPDX-License-Identifier: BSD-2-Clause
// Takes observations out of the window that the optimized poses contradict.
#pragma once

#include <boost/container/static_vector.hpp>

#include "estimator/window/window_cameras.h"

namespace facet {

struct OutlierCount {
    int observations = 0;  ///< left or right measurements taken out
    int landmarks = 0;     ///< landmarks left without enough observations and removed
};

/// Removes every measurement of an active landmark that lies farther from its reprojection than the threshold; a landmark
/// that is left with fewer than two keyframes is removed if it lost something. Observations of keyframes inside the prior
/// are removable as well: the prior does not hold them.
/// @param threshold_px  reprojection distance (px)
/// @param rejected      receives landmarks whose newest observation was taken out, or which were removed; full: the rest
///                      is left to the next keyframe
OutlierCount remove_outliers(double threshold_px, WindowState& state, const WindowCameras& cameras,
                             boost::container::static_vector<LandmarkId, kMaxFeatures>& rejected);

}  // namespace facet
