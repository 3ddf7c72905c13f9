// SPDX-License-Identifier: BSD-2-Clause
// The state at a frame between keyframes, from its image and the inertial samples since the newest keyframe.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <boost/container/static_vector.hpp>
#include <span>

#include "estimator/factors/imu_factor.h"
#include "estimator/imu/propagation.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/observation.h"
#include "estimator/window/local_map.h"

namespace facet {

/// What is known before a frame's image is used.
struct FramePrediction {
    const NavState& newest;              ///< state of the newest keyframe k
    const Preintegration& since_newest;  ///< samples from k to the frame
    const NavState& state;               ///< since_newest.predict(newest)
    const StateCovariance& covariance;   ///< of k's state, all that is not known of it
    const ImuNoise& noise;
};

/// What its image adds.
struct FrameEstimate {
    NavState state;
    StateCovariance covariance;
    int landmarks = 0;           ///< of the map, in the image
    int agreeing = 0;            ///< of those, with residuals below three standard deviations as modelled
    double chi2 = 0.0;           ///< c as measured: variance of the residuals over the expected one, without outliers
    double inertial_chi2 = 0.0;  ///< squared error of the samples and the newest keyframe, over a pose's dimension
};

/// How the image error of a track at the newest keyframe bears on a frame t later:  a = kSlow exp(-t / kMemory_s).
/// Measured are a = 0.77 after 0.25 s and 0.6 after 0.5 s (VisionNoise), and 1 - a^2 = 0.23, 0.29, 0.33 from the
/// residuals of frames 0.05, 0.1 and 0.15 s after a keyframe of one rendered log.
struct TrackMemory {
    static constexpr double kSlow = 0.92;  ///< the rest is new in every image
    static constexpr double kMemory_s = 1.3;

    double correlation = 0.0;     ///< a, of the errors
    double fresh_variance = 1.0;  ///< of what is new in the later one, whitened

    /// @param dt_s  from the keyframe to the frame
    static TrackMemory after(double dt_s);
};

/// One landmark in a frame n after the newest keyframe k, in units of the window's standard deviation:
///   r = r(x_n, point(x_k)) - a r(x_k, point(x_k))
struct SightResidual {
    Eigen::Vector2d r;
    Eigen::Matrix<double, 2, kPoseDim> d_r_d_newest;  ///< by the pose of k, which the point follows; order [theta p]
    Eigen::Matrix<double, 2, kPoseDim> d_r_d_frame;   ///< by the pose of n
    Eigen::Matrix2d covariance;                       ///< of r, given both poses
};

/// @param view         the point's chart as the frame's left camera sees it
/// @param newest_step  displacement of the newest keyframe's pose from where the map was built
/// @return kDegenerate if the point is behind the camera (then `out` is undefined). Reentrant. No heap.
Status linearize_sight(const MapPoint& point, const StereoMeasurement& left, const StereoGeometry& geometry,
                       const RelativeView& view, const Eigen::Matrix3d& R_B_W, const TrackMemory& memory,
                       const Eigen::Matrix<double, kPoseDim, 1>& newest_step, SightResidual& out);

/// Least squares over the newest keyframe's state x_k and the frame's x_n, few steps of Gauss-Newton:
///   |dx_k|^2_E + |inertial residual(x_k, x_n)|^2 + sum_i rho(|r_i|^2_S_i / c)
/// E is the covariance of x_k relative to the map (LocalMap), so that the drift that both share stays out of it. What
/// is left out of P_k, d ~ N(0, P_k - E), displaces the prediction, and the map with it: as a rigid body with k's pose,
/// and stretched in scale by what is left of its velocity. Images are the same if n is displaced by G d then,
///   theta_n = R_n^T w,    p_n = dp + w x (p_n - p_k) + t (dv - w x v_k),    w = R_k dtheta,
/// t being the time from k to n; they show what the biases would do. Least squares, not knowing d, answer it with
///   B = d x_n / d d = [0 I] H^-1 ([E^-1; 0] + H_images [I 0; G]),    P_n = C_n + B (P_k - E) B^T,
/// H being that of all terms, and C_n the last block of H^-1. Without images B is F, the inertial prediction's.
///
/// Image errors along a track change slowly: with their correlation a (TrackMemory), what is new at the frame is
/// z_n - a z_k, whose residual is
///   r_i = r(x_n, point_i) - a r(x_k, point_i),    S_i = (1 - a^2) s^2 / w_i + M cov(point_i) M^T,
///   M = d r(x_n) / d point_i - a d r(x_k) / d point_i,
/// s^2 the variance of a single observation, w_i the weight that the window gives the track, and point_i moving with
/// x_k as MapPoint says. Each frame starts from the keyframe, so no image counts twice. Shortly after it, errors of
/// tracks and landmarks cancel, and what remains is how far the vehicle has moved.
/// c: variance of the robust estimate over that of the residuals as modelled, from the residuals themselves
/// [Huber64]; at least one, because errors that all tracks share are not seen in it.
/// About 110 kB. Thread-bound. No heap.
class FrameUpdate {
public:
    static constexpr int kMinLandmarks = 8;

    /// @param observations  of the frame, as seen by the cameras of `cameras`
    /// @return kNotFound with fewer than kMinLandmarks of the map in the image; kDegenerate if the system cannot be
    ///         solved (out untouched)
    Status solve(const LocalMap& map, const WindowCameras& cameras, int keyframes, const FramePrediction& prediction,
                 std::span<const FeatureObservation> observations, FrameEstimate& out);

private:
    static constexpr int kDim = 2 * kStateDim;
    using Matrix = Eigen::Matrix<double, kDim, kDim>;
    using Vector = Eigen::Matrix<double, kDim, 1>;
    struct Sight {
        const MapPoint* point;
        StereoMeasurement measurement;
    };

    void collect(const LocalMap& map, const WindowCameras& cameras, int newest,
                 std::span<const FeatureObservation> observations);
    void add_images(const WindowCameras& cameras, int keyframes, const NavState& state, const RobustLoss& loss);
    void add_sight(const SightResidual& sight, const RobustLoss& loss);
    double measured_spread() const;
    void assemble(const LocalMap& map, const ImuFactorLinearization& imu);
    Status finish(const LocalMap& map, const FramePrediction& prediction, const NavState& state,
                  FrameEstimate& out) const;
    double inertial_error(const LocalMap& map, const ImuFactorLinearization& imu, const Vector& step) const;
    StateCovariance shared_drift(const LocalMap& map, const FramePrediction& prediction, const NavState& state,
                                 const StateCovariance& root) const;

    boost::container::static_vector<Sight, kMaxFeatures> sights_;
    boost::container::static_vector<RelativeView, kMaxKeyframes> views_;  ///< of the keyframes' charts
    TrackMemory memory_;
    double spread_ = 1.0;  ///< c
    LossSums sums_;
    int agreeing_ = 0;  ///< points below three standard deviations at the last linearization
    Eigen::Matrix<double, kStateDim, 1> newest_step_;  ///< dx_k
    /// Images' share of the normal equations: pose of k, pose of n.
    Eigen::Matrix<double, 2 * kPoseDim, 2 * kPoseDim> pose_h_;
    Eigen::Matrix<double, 2 * kPoseDim, 1> pose_g_;
    Matrix h_;  ///< lower triangle
    Vector g_;
    Eigen::LLT<Matrix> llt_;
};

}  // namespace facet
