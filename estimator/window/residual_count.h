// SPDX-License-Identifier: BSD-2-Clause
// Collects the residuals of a keyframe.
#pragma once

#include "estimator/values/residuals.h"
#include "estimator/window/window_cameras.h"

namespace facet {

/// Adds the residuals of the oldest keyframe's observations, at the current states; call WindowCameras::update()
/// before.
/// No heap. Reentrant.
void count_oldest_residuals(const WindowState& state, const WindowCameras& cameras, VisionResiduals& residuals);

}  // namespace facet
