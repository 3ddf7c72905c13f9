// SPDX-License-Identifier: BSD-2-Clause
// What yaw and place are uncertain by beyond what the window knows: earlier windows, motion it may have missed.
#pragma once

#include "estimator/flight/gauge.h"

namespace facet {

/// A frame's residuals, after its report.
struct SlipEvidence {
    bool is_high = false;      ///< beyond what errors explain
    bool is_keyframe = false;  ///< the frame takes part in the map
    Timestamp stamp;           ///< of the frame
    double dt_s = 0.0;         ///< since the frame before
};

/// While residuals are high the vehicle may have moved otherwise than estimated: the gauge is widened by the whole way
/// flown and angle turned. If the next frame whose residuals are not agrees with a map in which none of these frames
/// takes part, nothing has slipped but they, and the gauge is what it was. Thread-bound. No heap.
class GaugeTracker {
public:
    void begin_frame() { is_compared_ = false; }
    /// The frame at hand has been compared with a map. @param map  stamp of its newest keyframe
    void note_comparison(Timestamp map) {
        is_compared_ = true;
        compared_with_ = map;
    }

    /// What happened in the last dt_s seconds may not have happened: adds the way flown and the angle turned about the
    /// vertical to the standard deviations of position and yaw. @param w_B  rate of the body (rad/s)
    void widen(const NavState& state, const Eigen::Vector3d& w_B, double dt_s);

    /// After each frame. @return whether the gauge has changed
    bool step(const SlipEvidence& e, const NavState& state, const Eigen::Vector3d& w_B);

    /// After each keyframe. @param is_lost  the place is being regained @param moved_W  by what the keyframe moved it
    void follow(bool is_lost, const Eigen::Vector3d& moved_W) {
        leap_W_ = is_lost ? (leap_W_ + moved_W).eval() : Eigen::Vector3d::Zero();
    }
    /// After an outage that the window has bridged: adds a share of the way by which images have corrected the place.
    void add_leap(const Eigen::Vector3d& p_W);

    /// A window begins at a belief whose yaw and place it will take for known.
    void absorb(const Belief& belief) {
        gauge_.add(gauge_of(belief));
        drift_.add(gauge_of(belief));
    }

    /// Added to what is reported.
    const Gauge& gauge() const { return gauge_; }
    /// The share of it that windows have found of themselves, without what may have slipped.
    const Gauge& drift() const { return drift_; }

private:
    /// Residuals that stay high, and what the gauge was before.
    struct Slip {
        bool is_suspected = false;
        bool is_refutable = false;  ///< all of its frames were compared with a map, and none is a keyframe
        Timestamp begin;            ///< its first frame
        Gauge gauge;
    };

    Gauge gauge_;
    Gauge drift_;
    Slip slip_;
    Eigen::Vector3d leap_W_ = Eigen::Vector3d::Zero();  ///< by which keyframes have moved the place since it was lost
    bool is_compared_ = false;                          ///< the frame at hand, with a map
    Timestamp compared_with_;                           ///< the newest keyframe of that map
};

}  // namespace facet
