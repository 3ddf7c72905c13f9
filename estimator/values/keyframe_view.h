// SPDX-License-Identifier: BSD-2-Clause
// What the estimator knows about the points it sees: a snapshot of its window, taken at each keyframe.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "estimator/geometry/se3.h"
#include "estimator/values/camera_corrections.h"
#include "estimator/values/capacity.h"
#include "estimator/values/planes.h"
#include "platform/base/fixed_vector.h"
#include "platform/base/timestamp.h"
#include "platform/base/typed_id.h"

namespace facet {

/// One landmark as the newest optimization leaves it.
struct LandmarkSnapshot {
    LandmarkId id;
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< (m)
    /// Covariance of p_W given the window's poses (m^2): the inverse of sum J^T J over its sightings, J whitened by
    /// VisionNoise::cautious_px(). The poses' own uncertainty, common to neighbours, is left out.
    Eigen::Matrix3f covariance_W = Eigen::Matrix3f::Zero();
    float chi2 = 0.0F;           ///< whitened squared residual per degree of freedom of its sightings
    float depth_m = 0.0F;        ///< Z in the left camera of the newest keyframe; <= 0 behind it
    float depth_sigma_m = 0.0F;  ///< standard deviation along the ray from there
    int keyframes = 0;           ///< number of keyframes of the window that see it
    int stereo = 0;              ///< number of these with a right match
    Timestamp first_stamp;       ///< of the oldest of these: when that keyframe leaves, an ended track leaves with it
    int unseen_keyframes = 0;    ///< keyframes since it was last seen; 0: seen in the newest one
    bool is_tracked = false;     ///< seen in the newest keyframe; then:
    Eigen::Vector2d left_xy = Eigen::Vector2d::Zero();  ///< normalised, undistorted, in C0
    Eigen::Vector2f left_px = Eigen::Vector2f::Zero();  ///< distorted pixel in the left image
    PlaneId plane;                                      ///< plane that the estimator holds it on; invalid if none
};

/// A keyframe of the window as the newest optimization leaves it.
struct KeyframePose {
    Timestamp stamp;
    Se3 T_W_C0;  ///< left camera
};

/// The window at its newest keyframe: its landmarks, by increasing id, and the points that only that keyframe's stereo
/// pair shows. Points that cannot be triangulated, or whose position is practically at infinity, are left out. About
/// 350 KB: allocate it once. Thread-bound. No heap.
struct KeyframeView {
    using HeadingAndPlace = Eigen::Matrix4d;

    std::uint32_t number = 0;  ///< counts the views since configure(): identifies a new one
    Timestamp stamp;           ///< of the newest keyframe
    Timestamp oldest_stamp;    ///< of the oldest one in the window
    Se3 T_W_C0;                ///< left camera of the newest keyframe
    /// Covariance of what drifts of the newest keyframe's body: turn about the vertical (rad), place in W (m); with
    /// what earlier windows did not know of them, but without what may have slipped while residuals were high.
    HeadingAndPlace heading_and_place = HeadingAndPlace::Zero();
    /// The right camera plays the left one, because that fails: what is said of C0 and the left image is the right's.
    bool is_exchanged = false;
    /// Variance of the sightings as measured, in units of the cautious one that covariance_W is based on: multiply by
    /// it to test whether points agree.
    double observation_variance = 1.0;
    FixedVector<LandmarkSnapshot, kMaxLandmarks> landmarks;
    /// Points between the landmarks that only the newest keyframe has measured, by increasing id, all ids above those
    /// of the landmarks. Each is reported once: a consumer that keeps them must move them with their keyframe.
    FixedVector<LandmarkSnapshot, kMaxSurfacePoints> surface;
    FixedVector<KeyframePose, kMaxKeyframes> keyframes;  ///< oldest first
    CameraCorrections cameras;                           ///< no covariance if the calibration is not estimated
    PlaneEstimates planes;                               ///< planes that the estimator uses; empty in mode S

    /// Nothing has been seen yet.
    void clear() {
        number = 0;
        landmarks.clear();
        surface.clear();
        keyframes.clear();
        planes.clear();
    }
};

}  // namespace facet
