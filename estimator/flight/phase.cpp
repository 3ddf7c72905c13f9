// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/phase.h"

namespace facet {
namespace {

// A restart in flight needs this many stereo matches, which connect the first keyframes. Where there is one camera only
// it needs this many features: there the inertial samples connect the keyframes until the motion does.
constexpr int kRestartStereo = 20;
constexpr int kRestartFeatures = 20;
// When a rest ends and the newest keyframe is this old, a new one follows at once: the prediction is too old.
constexpr double kStaleKeyframe_s = 0.5;
// A lost window over whose newest inertial interval this time has passed begins anew: over ten seconds what is not
// linear in tilt and bias leads farther astray than images correct.
constexpr double kLongestGap_s = 10.0;
// A start waits for the velocity and the tilt, which keyframes tell, at least this far apart.
constexpr double kStartSpacing_s = 0.09;
// Suspected readings are compared with the motion between keyframes: by places that are right to millimetres a force is
// told to 1 m/s^2 over this time (inertial_fault.cpp), a tenth of what a dead accelerometer lacks.
constexpr double kFaultSpacing_s = 0.14;

}  // namespace

bool must_restart(const PredictionEvidence& e) {
    const bool has_long_gap = e.is_lost && e.keyframe_age_s > kLongestGap_s;
    return e.is_beyond_recovery || has_long_gap || e.reset_wanted || e.phase == Phase::kCoasting;
}

bool wants_keyframe(const PredictionEvidence& e) {
    const bool has_moved_off = e.phase == Phase::kHolding && !e.rests && e.keyframe_age_s > kStaleKeyframe_s;
    const bool hastens_start = (e.is_starting || e.is_lost) && e.keyframe_age_s > kStartSpacing_s;
    const bool hastens_trust = e.is_replaced && e.keyframe_age_s > kFaultSpacing_s;
    return must_restart(e) || e.inertial_data_poor || has_moved_off || hastens_start || hastens_trust;
}

FrameAction decide(const FrameEvidence& e) {
    const bool sees_enough = e.stereo >= kRestartStereo || e.lone_features >= kRestartFeatures;
    if (e.is_keyframe && e.must_restart && sees_enough) {
        return FrameAction::kRestart;
    }
    if (e.phase == Phase::kCoasting) {
        return FrameAction::kCarryOn;
    }
    if (e.is_keyframe) {
        return FrameAction::kTakeKeyframe;
    }
    return e.rests && e.image_is_still ? FrameAction::kHold : FrameAction::kCarryOn;
}

}  // namespace facet
