// SPDX-License-Identifier: BSD-2-Clause
// A start in motion: velocity, gravity and biases without a first guess, and with one camera the scale.
#pragma once

#include <array>
#include <boost/container/static_vector.hpp>
#include <optional>
#include <span>

#include "estimator/api/belief.h"
#include "estimator/flight/motion_problem.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/imu/delay_search.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/values/capacity.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/nav_state.h"
#include "estimator/values/observation.h"

namespace facet {

/// Collects what the cameras see at keyframes, and the inertial samples between them, and solves for the state without
/// an initial guess (MotionProblem). Scale follows from stereo matches, or, with one camera, from the accelerometer.
///
/// A window that begins in motion with stereo matches starts with the mean force as gravity and refines that itself;
/// check() shows whether its optimization has ended in another minimum. With one camera it begins from solve().
/// About 600 KiB. Thread-bound. No heap.
class MotionStart {
public:
    using Information = Eigen::Matrix<double, kStateDim, kStateDim>;

    /// @param bearing_sigma  of a sighting, normalised image coordinates
    void configure(const StereoRig& rig, const ImuNoise& noise, double gravity_m_per_s2, double bearing_sigma);
    void reset() { keyframes_.clear(); }
    /// Whether the newest keyframe has this stamp.
    bool ends_at(Timestamp stamp) const { return !keyframes_.empty() && keyframes_.back().stamp == stamp; }

    /// Takes a keyframe; when full, the oldest is forgotten.
    /// @param belief  at the stamp, of whose biases the first keyframe's are the prior: what came later may be of the
    ///                same images
    void add_keyframe(Timestamp stamp, std::span<const FeatureObservation> observations, const ImuBuffer& imu,
                      const Belief& belief);

    /// The state at the newest keyframe, at the position and yaw of `state`.
    /// @param information  of `solved`, order [theta p v bg ba]: that of position and yaw is as at a start
    /// @return kNotReady with too few keyframes or points; kDegenerate if the motion does not determine velocity to
    ///         0.3 m/s, gravity to 0.1 rad and, with one camera, the path's scale to 5 %, or the sightings do not fit
    ///         (outputs untouched).
    Status solve(const NavState& state, NavState& solved, Information& information);

    /// Solves, and compares with the window's state at the newest keyframe. @return as solve(); kNotFound if both agree
    /// within what either may err.
    Status check(const NavState& state, NavState& better, Information& information);

    /// What must be added to the images' stamps for the sightings to fit, where they do not without. With one camera
    /// only, of the last solve() or check().
    const std::optional<ImageDelay>& delay() const { return delay_; }

private:
    static constexpr std::size_t kMostKeyframes = MotionProblem::kMostKeyframes;
    using Unknowns = MotionProblem::Unknowns;
    using Normal = MotionProblem::Normal;
    using Places = MotionProblem::Places;

    struct Bearing {
        LandmarkId landmark;
        Eigen::Vector3d left_B = Eigen::Vector3d::Zero();   ///< of unit length
        Eigen::Vector3d right_B = Eigen::Vector3d::Zero();  ///< zero: no match
        bool has_right() const { return !right_B.isZero(); }
    };
    struct View {
        Timestamp stamp;
        Preintegration link;                    ///< from the keyframe before
        std::optional<Eigen::Vector3d> rate_B;  ///< rad/s; none where the samples do not reach back
        boost::container::static_vector<Bearing, kMaxFeatures> bearings;  ///< by increasing landmark
    };
    struct Solution {
        Unknowns x = Unknowns::Zero();
        Places places;  ///< with the gyroscope bias and the delay of x
        MotionProblem::Sums sums;
    };

    Places chain(const ImuBias& bias, double delay_s) const;
    /// Most points of the keyframe in the middle have a match.
    bool has_stereo() const;
    void collect_points();
    /// @return kNotReady with too few points, kDegenerate if there is no solution
    Status solve(Solution& solution);
    /// From all first guesses there are. @param best  that of the least cost @return as minimize()
    Status minimize_from_all(double delay_sigma_s, Solution& best);
    /// Levenberg's method from solution.x. @return kDegenerate without a finite step
    Status minimize(const ImuBias& bias, Solution& solution);
    static bool fits(const Solution& solution);
    /// Tries whether the sightings fit with images that are late. @param without  the solution for images that are not
    void find_delay(const Solution& without);
    /// 1 sigma, of the largest axis.
    struct Sigma {
        double velocity = 0.0;  ///< at the newest keyframe
        double tilt = 0.0;      ///< of gravity's direction
        double gyro_bias = 0.0;
        double scale = 0.0;  ///< of the path, relative
    };
    Sigma sigma(const Solution& solution) const;

    StereoRig rig_;
    ImuNoise noise_;
    double gravity_m_per_s2_ = 0.0;
    MotionProblem problem_;
    std::optional<ImageDelay> delay_;
    MotionProblem::BiasPrior bias_prior_;  ///< at the first keyframe
    boost::container::static_vector<View, kMostKeyframes> keyframes_;
};

}  // namespace facet
