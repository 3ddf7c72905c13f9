// SPDX-License-Identifier: BSD-2-Clause
// A second opinion on a start in motion: velocity and gravity in closed form from stereo points and inertial samples.
#pragma once

#include <array>
#include <boost/container/static_vector.hpp>
#include <span>

#include "estimator/geometry/stereo_rig.h"
#include "estimator/imu/dynamic_init.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/stereo_motion.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/nav_state.h"
#include "estimator/values/observation.h"

namespace facet {

/// Collects the motions between the first keyframes and solves them for velocity, gravity and biases without an initial
/// guess (dynamic_init.h). The window itself starts with the mean force as gravity and refines that. If this guess was
/// so wrong that the window's optimization ended in another minimum, the comparison shows it. Usage, while the
/// estimator is in INIT after a moving start:
///   start.reset(); start.add_keyframe(...) at every keyframe; if (ok(start.check(...))) restart from `better`.
/// About 150 KiB, and 200 KiB of stack. Thread-bound. No heap.
class MotionStart {
public:
    void configure(const StereoRig& rig, const ImuNoise& noise, double gravity_m_per_s2, double pixel_sigma_px);
    void reset();

    /// Takes a keyframe; if its motion cannot be found, the collection restarts.
    void add_keyframe(Timestamp stamp, std::span<const FeatureObservation> observations, const ImuBuffer& imu);

    /// Compares the window's state at the newest keyframe with the closed-form solution.
    /// @param better       the solution, at the position and yaw of `state`
    /// @param information  of `better`, order [theta p v bg ba]
    /// @return kOk if there is a solution and the state differs from it by more than both may err: use `better`;
    ///         kNotFound if there is no solution yet, or the state agrees with it (outputs untouched).
    Status check(const NavState& state, NavState& better,
                 Eigen::Matrix<double, kStateDim, kStateDim>& information) const;

private:
    struct Point {
        LandmarkId landmark;
        StereoPlace place;
    };
    using PointList = boost::container::static_vector<Point, kMaxFeatures>;

    StereoRig rig_;
    ImuNoise noise_;
    double gravity_m_per_s2_ = 0.0;
    double pixel_sigma_px_ = 0.5;
    Timestamp stamp_;   ///< of the newest keyframe
    PointList points_;  ///< seen there in stereo, by increasing id
    PointList next_;    ///< of the keyframe being added: a member to spare the stack
    boost::container::static_vector<KeyframeMotion, kMaxInitKeyframes - 1> motions_;
};

}  // namespace facet
