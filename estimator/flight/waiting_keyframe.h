// SPDX-License-Identifier: BSD-2-Clause
// A keyframe between its own frame and its turn in the window.
#pragma once

#include "estimator/api/belief.h"
#include "estimator/frontend/frontend_types.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/preintegration.h"
#include "estimator/window/window.h"

namespace facet {

/// What the window needs of a keyframe whose turn comes after the estimate of the frame that follows it; all as it was
/// at its own frame.
struct WaitingKeyframe {
    bool is_set = false;
    bool wants_view = false;        ///< somebody asks for views of keyframes
    FrontendOutput tracks;          ///< with surface points, once they are matched
    KeyframeInput input;            ///< its observations are those of `tracks`
    Belief predicted;               ///< by inertial samples
    NavState guess;                 ///< where the optimization begins, if the input says so
    Preintegration preintegration;  ///< from the keyframe before
    ImuSpan span;                   ///< of the same samples
    double effort = 1.0;            ///< of the solver
};

}  // namespace facet
