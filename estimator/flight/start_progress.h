// SPDX-License-Identifier: BSD-2-Clause
// How far a start has come: what supports its velocity, and whether the vehicle stands.
#pragma once

#include <algorithm>
#include <cstdint>

#include "platform/base/timestamp.h"

namespace facet {

/// A keyframe with fewer stereo matches is one of a single camera: velocity and scale have to come from the motion.
inline constexpr int kStereoStart = 8;

/// A window that began as at rest by inertial samples alone: a glide at constant speed looks the same to them.
enum class RestClaim : std::uint8_t {
    kNone,     ///< it did not, or it has been settled
    kOpen,     ///< images have said nothing yet: INIT
    kSeen,     ///< images agree so far
    kRefuted,  ///< images move: the window restarts at the next frame that allows it
};

/// The images since the window began.
struct StillnessEvidence {
    bool is_usable = false;     ///< the image can be tracked
    bool is_starting = false;   ///< INIT
    int tracked = 0;            ///< features carried over from the frame before
    double disparity_px = 0.0;  ///< median since the newest keyframe, small at rest
    double threshold_px = 0.0;  ///< below it the image is still
};

/// State of a start, from the first frame of a window until its velocity is known. Thread-bound. No heap.
class StartProgress {
public:
    /// A window begins. @param has_velocity  it is known from before, or stereo matches will tell it
    void begin_window(Timestamp stamp, bool has_velocity, bool has_answer) {
        window_began_ = stamp;
        is_confirmed_ = has_velocity;
        awaits_answer_ = !has_velocity && !has_answer;
    }
    /// The first window. @param is_still  begun as at rest, by inertial samples
    void begin_first(bool is_still) {
        claim_ = is_still ? RestClaim::kOpen : RestClaim::kNone;
        may_stand_ = !is_still;
    }
    /// The window has restarted in flight, or as in motion.
    void drop_claim() { claim_ = RestClaim::kNone; }
    void renew() {
        claim_ = RestClaim::kNone;
        is_renewed_ = true;
    }

    /// Velocity is known from before the window began, or by a start in motion that agrees with the window.
    bool is_confirmed() const { return is_confirmed_; }
    void confirm() { is_confirmed_ = true; }
    /// A start with one camera whose velocity nothing tells yet: keyframes are collected, the window is not optimized.
    bool awaits_answer() const { return awaits_answer_; }
    void await_answer() { awaits_answer_ = true; }
    /// Whether no estimate may be given yet.
    bool is_open() const {
        return !is_confirmed_ || may_stand_ || claim_ == RestClaim::kOpen || claim_ == RestClaim::kRefuted;
    }
    double age_s(Timestamp now) const { return (now - window_began_).seconds(); }
    Timestamp window_began() const { return window_began_; }
    bool is_renewed() const { return is_renewed_; }

    RestClaim claim() const { return claim_; }
    bool is_claimed() const { return claim_ == RestClaim::kOpen || claim_ == RestClaim::kSeen; }
    /// Whether images can judge the start. @param e  of the frame at hand
    bool can_judge_claim(const StillnessEvidence& e) const {
        return is_claimed() && e.is_usable && e.tracked >= kFewTracks;
    }
    /// @param samples_rest  a start at this frame would be at rest, too
    void judge_claim(const StillnessEvidence& e, bool samples_rest, Timestamp now);
    /// A keyframe has been taken: what images have said so far stands.
    void settle_claim() { claim_ = claim_ == RestClaim::kSeen ? RestClaim::kNone : claim_; }

    /// Begun as in motion, with images that have not moved since.
    bool may_stand() const { return may_stand_; }
    void judge_stand(const StillnessEvidence& e) {
        may_stand_ =
            may_stand_ && e.is_starting && e.is_usable && e.tracked >= kFewTracks && e.disparity_px <= e.threshold_px;
    }
    /// Images have been still for long enough to begin as at rest, however much rotors shake the samples.
    bool stands_long_enough(Timestamp now) const { return age_s(now) >= kShakenRest_s - kStampSlack_s; }
    void end_stand() { may_stand_ = false; }
    /// The window has restarted as at rest.
    void begin_shaken_rest() {
        claim_ = RestClaim::kSeen;
        forced_keyframes_ = kForcedAtRest;
    }

    /// Keyframes shall follow each other as fast as at a start.
    bool forces_keyframes() const { return forced_keyframes_ > 0; }
    void count_keyframe() { forced_keyframes_ = std::max(0, forced_keyframes_ - 1); }

private:
    static constexpr int kFewTracks = 8;  ///< the median of fewer says nothing
    /// A rest that images have confirmed for this long was one, however smoothly the vehicle takes off later: what
    /// moves by less than half a pixel in that time at 10 m flies less than 4 cm/s.
    static constexpr double kSettled_s = 0.29;
    /// A vehicle that rotors shake stands if its images do for this long.
    static constexpr double kShakenRest_s = 0.3;
    static constexpr double kStampSlack_s = 1e-3;
    /// After a rest, of either kind, so many keyframes come as fast as at any start: one alone holds neither the place
    /// nor what shaking has made of the velocity.
    static constexpr int kForcedAtRest = 4;

    Timestamp window_began_;
    bool is_confirmed_ = true;
    bool awaits_answer_ = false;
    RestClaim claim_ = RestClaim::kNone;
    bool may_stand_ = false;
    int forced_keyframes_ = 0;
    bool is_renewed_ = false;
};

inline void StartProgress::judge_claim(const StillnessEvidence& e, bool samples_rest, Timestamp now) {
    if (!samples_rest) {
        claim_ = RestClaim::kNone;  // it moves off, and the inertial samples show how
    } else if (e.disparity_px > e.threshold_px) {
        claim_ = RestClaim::kRefuted;
    } else if (age_s(now) <= kSettled_s) {
        claim_ = RestClaim::kSeen;
    } else {  // it stands
        claim_ = RestClaim::kNone;
        forced_keyframes_ = kForcedAtRest;
    }
}

}  // namespace facet
