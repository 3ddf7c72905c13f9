// SPDX-License-Identifier: BSD-2-Clause
// Decides which frames become keyframes.
#pragma once

#include "estimator/frontend/frontend_config.h"
#include "platform/base/timestamp.h"

namespace facet {

/// What the policy looks at in one frame, compared with the last keyframe.
struct KeyframeEvidence {
    Timestamp stamp;
    int live_tracks = 0;        ///< tracks of the last keyframe that are still alive
    int keyframe_tracks = 0;    ///< tracks the last keyframe had
    double disparity_px = 0.0;  ///< rotation-compensated median
    bool has_right = false;
    bool is_asked_for = false;  ///< FrameHints::wants_keyframe
};

/// A frame is a keyframe if it is the first, if one is asked for, or if at least kKeyframeMinInterval_s has passed
/// since the last one and
///   - the share of its tracks still alive fell below kKeyframeOverlap, or it had none, or
///   - the disparity exceeds keyframe_disparity_px, or
///   - the last keyframe lacked the right image and this frame has it, or
///   - keyframe_max_interval_s has passed: the only possible reason when standing still.
/// Thread-bound. No heap.
class KeyframePolicy {
public:
    void configure(const FrontendConfig& config) {
        config_ = config;
        reset();
    }
    void reset() { has_keyframe_ = false; }

    /// True if the frame is to be a keyframe; it then becomes the last keyframe.
    bool decide(const KeyframeEvidence& evidence);

private:
    FrontendConfig config_;
    bool has_keyframe_ = false;
    bool last_has_right_ = false;
    Timestamp last_;
};

}  // namespace facet
