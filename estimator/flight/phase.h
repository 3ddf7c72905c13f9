// SPDX-License-Identifier: BSD-2-Clause
// What the estimator is doing, and what it does with the next frame: a state machine without side effects.
#pragma once

#include <cstdint>

namespace facet {

/// Where the newest state comes from. README.md ("Phases") draws the transitions.
enum class Phase : std::uint8_t {
    kEmpty,      ///< no frame yet
    kWaiting,    ///< frames, but no window: inertial data do not suffice for a start
    kFollowing,  ///< carried from the newest keyframe by the inertial samples since
    kHolding,    ///< the newest keyframe's: the vehicle has not moved since
    kCoasting,   ///< carried from frame to frame: inertial samples no longer reach back to the newest keyframe
};

/// There is a window, so that a state is estimated, well or badly.
constexpr bool has_window(Phase phase) { return phase >= Phase::kFollowing; }

/// Information about a frame after its inertial prediction, before its images are examined.
struct PredictionEvidence {
    Phase phase = Phase::kFollowing;
    bool is_lost = false;             ///< judged so by the health monitor, and it may end without the user
    bool is_beyond_recovery = false;  ///< and the window will not recover
    bool reset_wanted = false;        ///< requested by the user
    bool inertial_data_poor = false;  ///< a gap or clipped samples since the newest keyframe
    bool rests = false;               ///< at rest by inertial samples and images since the newest keyframe
    bool is_starting = false;         ///< in stereo; no estimate has been ready yet, or the window has restarted
    bool is_replaced = false;         ///< readings are replaced until keyframes agree with them, and do not hang
    double keyframe_age_s = 0.0;
};

/// Whether the window shall restart at the next frame that allows it.
bool must_restart(const PredictionEvidence& e);

/// Whether the front-end should make this frame a keyframe if it can: to restart, because only vision can determine
/// where the vehicle is, because a start is ready the sooner, or a window that has restarted knows its velocity the
/// sooner, or one that is lost recovers, because suspected readings are used again the sooner, or because a rest with
/// an old keyframe has ended.
bool wants_keyframe(const PredictionEvidence& e);

/// Information about a frame after the front-end has tracked it.
struct FrameEvidence {
    Phase phase = Phase::kFollowing;
    bool must_restart = false;
    bool is_keyframe = false;
    int stereo = 0;               ///< features with a right match
    bool rests = false;           ///< at rest since the newest keyframe, this frame included
    bool image_is_still = false;  ///< the images show no motion since the newest keyframe
    int lone_features = 0;        ///< features in a frame of one camera whose other one is silent; 0 with a pair
};

enum class FrameAction : std::uint8_t {
    kCarryOn,       ///< the inertial prediction stands
    kTakeKeyframe,  ///< into the window, which is optimized
    kHold,          ///< the newest keyframe's state stands
    kRestart,       ///< begin a new window at this frame, from the state carried on so far
};

FrameAction decide(const FrameEvidence& e);

}  // namespace facet
