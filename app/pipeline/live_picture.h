// SPDX-License-Identifier: BSD-2-Clause
// A frame's result as a flight's viewers are shown it.
#pragma once

#include "app/pipeline/frame_pipeline.h"
#include "app/view/flight_viewer.h"
#include "estimator/values/keyframe_view.h"
#include "platform/base/samples.h"

namespace facet {

/// Means over squares of pixels, the smallest squares that keep the longer side within FlightViewer::kMaxPictureSide.
/// @param picture  size and pixels are set; the vector's capacity suffices for any image
/// @return side of the squares (px)
int shrink(const ImageView& image, ViewPicture& picture);

/// Offers a frame's health and times, with the pose if it is to be used, the mesh over the horizon and the planes if
/// the frame has brought them, the left image with the keyframe's landmarks, and the calibration, if the view wants
/// them. As FlightViewer::offer().
/// @param seen  of the newest keyframe; looked at if that is this frame
void show_frame(const FrameResult& result, const StereoFrame& frame, const KeyframeView& seen,
                const FramePipeline& pipeline, FlightViewer& view);

}  // namespace facet
