// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/keyframe_policy.h"

namespace facet {
namespace {

/// Image stamps jitter: an interval this much short still counts as reached (s).
constexpr double kStampSlack_s = 1e-3;

}  // namespace

bool KeyframePolicy::decide(const KeyframeEvidence& e) {
    bool is_keyframe = !has_keyframe_;
    if (has_keyframe_) {
        const double elapsed_s = (e.stamp - last_).seconds() + kStampSlack_s;
        const bool overlap_low =
            e.live_tracks == 0 || e.live_tracks < FrontendConfig::kKeyframeOverlap * e.keyframe_tracks;
        const bool wanted = overlap_low || e.disparity_px > config_.keyframe_disparity_px ||
                            (e.has_right && !last_has_right_) || elapsed_s >= config_.keyframe_max_interval_s;
        is_keyframe = e.is_asked_for || (wanted && elapsed_s >= FrontendConfig::kKeyframeMinInterval_s);
    }
    if (is_keyframe) {
        has_keyframe_ = true;
        last_ = e.stamp;
        last_has_right_ = e.has_right;
    }
    return is_keyframe;
}

}  // namespace facet
