// SPDX-License-Identifier: BSD-2-Clause
// A start in motion: velocity, gravity and biases in closed form, and with one camera the scale.
#pragma once

#include <array>
#include <boost/container/static_vector.hpp>
#include <span>

#include "estimator/geometry/stereo_rig.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/values/capacity.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/nav_state.h"
#include "estimator/values/observation.h"

namespace facet {

/// Collects what the cameras see at keyframes, and the inertial samples between them, and solves for the state without
/// an initial guess. In the body frame at the oldest keyframe, with bearings d_ik of point i in either camera and
/// camera centres
///   c_k = v t_k + 1/2 g t_k^2 + dp_k(ba, bg) + R_k p_B_C,
/// each sighting says that X_i - c_k is parallel to d_ik: (I - d d^T)(X_i - c_k) = 0, linear in the point, in velocity
/// v, gravity g and accelerometer bias ba; points are eliminated one by one. Reweighted with the depths that come out,
/// with a Cauchy loss, with |g| as known, and with the gyroscope bias to first order. The scale follows from stereo
/// matches, or, with one camera, from the accelerometer. [Martinelli14]
///
/// A window that begins in motion with stereo matches starts with the mean force as gravity and refines that itself;
/// check() shows whether its optimization has ended in another minimum. With one camera it begins from solve().
/// About 500 KiB. Thread-bound. No heap.
///
/// [Martinelli14] Closed-form Solution of Visual-Inertial Structure from Motion, IJCV 2014.
class MotionStart {
public:
    using Information = Eigen::Matrix<double, kStateDim, kStateDim>;

    /// @param bearing_sigma  of a sighting, normalised image coordinates
    void configure(const StereoRig& rig, const ImuNoise& noise, double gravity_m_per_s2, double bearing_sigma);
    void reset() { keyframes_.clear(); }
    /// Whether the newest keyframe has this stamp.
    bool ends_at(Timestamp stamp) const { return !keyframes_.empty() && keyframes_.back().stamp == stamp; }

    /// Takes a keyframe; when full, the oldest is forgotten.
    void add_keyframe(Timestamp stamp, std::span<const FeatureObservation> observations, const ImuBuffer& imu,
                      const ImuBias& bias);

    /// The state at the newest keyframe, at the position and yaw of `state`.
    /// @param information  of `solved`, order [theta p v bg ba]: that of position and yaw is as at a start
    /// @return kNotReady with too few keyframes or points, or, with one camera, too short a time; kDegenerate if the
    ///         motion does not tell velocity to 0.3 m/s and gravity to 0.1 rad, or the sightings do not fit (outputs
    ///         untouched).
    Status solve(const NavState& state, NavState& solved, Information& information) const;

    /// Solves, and compares with the window's state at the newest keyframe. @return as solve(); kNotFound if both agree
    /// within what either may err.
    Status check(const NavState& state, NavState& better, Information& information) const;

private:
    static constexpr std::size_t kMostKeyframes = 12;
    static constexpr std::size_t kMostPoints = 128;
    static constexpr int kUnknowns = 12;  // v g ba bg
    using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
    using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
    using Centre = Eigen::Matrix<double, 3, kUnknowns>;

    struct Bearing {
        LandmarkId landmark;
        Eigen::Vector3d left_B = Eigen::Vector3d::Zero();   ///< of unit length
        Eigen::Vector3d right_B = Eigen::Vector3d::Zero();  ///< zero: no match
        bool has_right() const { return !right_B.isZero(); }
    };
    struct View {
        Timestamp stamp;
        Preintegration link;                                              ///< from the keyframe before
        boost::container::static_vector<Bearing, kMaxFeatures> bearings;  ///< by increasing landmark
    };
    /// One keyframe as the oldest one's body frame sees it.
    struct Place {
        double t_s = 0.0;
        Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
        Eigen::Matrix3d d_theta_d_bg = Eigen::Matrix3d::Zero();
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        Eigen::Vector3d v = Eigen::Vector3d::Zero();
        Eigen::Matrix<double, 3, 6> d_p_d_b = Eigen::Matrix<double, 3, 6>::Zero();  ///< [bg ba]
        Eigen::Matrix<double, 3, 6> d_v_d_b = Eigen::Matrix<double, 3, 6>::Zero();
    };
    using Places = boost::container::static_vector<Place, kMostKeyframes>;
    struct Solution {
        Unknowns x = Unknowns::Zero();
        Normal information = Normal::Zero();
        int points = 0;
        int behind = 0;  ///< of these, behind a camera
        int sightings = 0;
        int misfits = 0;  ///< of these, off by more than 3 sigma
    };
    struct Sight {
        Eigen::Vector3d d;
        const Place* place;
        const Eigen::Vector3d* p_B_C;
    };
    using Sights = boost::container::static_vector<Sight, 2 * kMostKeyframes>;

    Places chain(const ImuBias& bias) const;
    /// Most points of the keyframe in the middle have a match.
    bool has_stereo() const;
    Sights sights_of(LandmarkId landmark, const Places& places) const;
    Status iterate(const Places& places, int step, Solution& solution) const;
    void add_point(const Sights& sights, int step, const Unknowns& last, Solution& sums, Unknowns& gradient) const;
    static Centre centre_of(const Sight& sight, double depth);
    static bool fits(const Solution& solution);
    bool is_known(const Solution& solution, const Place& newest) const;

    StereoRig rig_;
    ImuNoise noise_;
    double gravity_m_per_s2_ = 0.0;
    double bearing_sigma_ = 2e-3;
    boost::container::static_vector<View, kMostKeyframes> keyframes_;
};

}  // namespace facet
