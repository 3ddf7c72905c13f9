// SPDX-License-Identifier: BSD-2-Clause
// What the window knows around its newest keyframe, kept for the frames that follow it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <boost/container/static_vector.hpp>

#include "estimator/imu/propagation.h"
#include "estimator/solver/reduced_system.h"
#include "estimator/window/window_cameras.h"

namespace facet {

/// A landmark seen by the newest keyframe k, as linear in the pose of k as the window is, whose older poses are held:
///   point(x_k) ~ N(point + d_point_d_pose dx_k, covariance)
/// Residuals are whitened: pixels over the standard deviation that the window gives observations.
struct MapPoint {
    LandmarkId id;
    int host = 0;                                       ///< keyframe in whose left camera's chart the point is
    InverseDepthPoint point;                            ///< the window's
    Eigen::Matrix3d covariance;                         ///< of [x y rho], given all poses
    Eigen::Matrix<double, 3, kPoseDim> d_point_d_pose;  ///< how it follows the newest keyframe, order [theta p]
    Eigen::Vector2d residual;                           ///< of k's left image
    Eigen::Matrix<double, 2, 3> d_residual_d_point;
    Eigen::Matrix<double, 2, kPoseDim> d_residual_d_pose;  ///< the point's following included
    double weight = 1.0;                                   ///< that the robust loss gives the residual
};

/// The landmarks that the newest keyframe sees, and how well its state is known relative to the older keyframes' poses.
/// Landmarks and newest keyframe share the error of those poses: how far one is from the others is known far better
/// than where all of them are. Valid until the window changes. About 250 kB. Thread-bound. No heap.
class LocalMap {
public:
    void clear() { points_.clear(); }

    /// Takes everything from a window after its optimization.
    /// @param system  the window's, at its present states
    /// @return kDegenerate if the newest state is not determined (map empty then)
    Status build(const WindowState& state, const WindowCameras& cameras, const ReducedSystem& system);

    bool empty() const { return points_.empty(); }
    /// By increasing id.
    const boost::container::static_vector<MapPoint, kMaxFeatures>& points() const { return points_; }
    /// The point of a landmark, or nullptr.
    const MapPoint* find(LandmarkId id) const;
    /// Covariance of the newest keyframe's state, order [theta p v bg ba], given the poses of the others and all else
    /// that keyframes share.
    const StateCovariance& newest_covariance() const { return newest_covariance_; }
    /// Its inverse.
    const StateCovariance& newest_information() const { return newest_information_; }

private:
    void add(const Landmark& landmark, const WindowState& state, const WindowCameras& cameras);

    boost::container::static_vector<MapPoint, kMaxFeatures> points_;
    StateCovariance newest_covariance_ = StateCovariance::Zero();
    StateCovariance newest_information_ = StateCovariance::Zero();
};

/// Information of the newest keyframe's state given the older keyframes' poses and all globals: what those are held at
/// leaves a chain of velocities and biases, each tied to its neighbours only, which is eliminated from its old end on,
///   S_0 = H_00,   S_j = H_jj - H_j,j-1 S_j-1^-1 H_j-1,j,     j = 1 ... k, the last one with its pose.
/// @return kDegenerate if a block is not positive definite (output undefined). Reentrant. No heap.
Status newest_information(const ReducedSystem& system, StateCovariance& information);

}  // namespace facet
