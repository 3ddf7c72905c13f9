// SPDX-License-Identifier: BSD-2-Clause
// Takes the snapshot of the window that the mesher and the plane finder read.
#pragma once

#include "estimator/frontend/frontend_types.h"
#include "estimator/values/keyframe_view.h"
#include "estimator/window/window.h"

namespace facet {

/// Fills the view from the window after optimize(). Landmarks that only the newest keyframe sees are triangulated from
/// their stereo match alone.
/// @param tracks  the front-end's observations at the newest keyframe; they provide the pixels
void fill_keyframe_view(const Window& window, const FrontendOutput& tracks, KeyframeView& view);

}  // namespace facet
