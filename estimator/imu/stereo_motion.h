// SPDX-License-Identifier: BSD-2-Clause
// How the body moved between two keyframes, from points with a stereo depth in both.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "estimator/geometry/se3.h"
#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// A point in the left camera, as one stereo observation gives it.
struct StereoPlace {
    Eigen::Vector3d p_C0 = Eigen::Vector3d::UnitZ();                     ///< z > 0 (m)
    Eigen::Matrix3d covariance_C0 = 1e-4 * Eigen::Matrix3d::Identity();  ///< stereo_covariance() (m^2)
};

/// One point at two times.
struct StereoPoint {
    StereoPlace then;
    StereoPlace now;
};

/// Units, ranges and meanings: kStereoMotionFields below.
struct StereoMotionConfig {
    double rotation_sigma_rad = 0.1;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kStereoMotionFields = std::to_array<ParameterField<StereoMotionConfig>>({
    {FACET_FIELD(StereoMotionConfig, rotation_sigma_rad), "rad", 1e-5, 0.5,
     "Standard deviation of each axis of the given rotation: the gyroscope's over the interval to rely on it; 0.1 rad "
     "to take the rotation from the points alone, as initialize_in_motion() needs it for the gyroscope bias."},
});

/// Motion of the body from then (i) to now (j).
struct StereoMotion {
    Eigen::Quaterniond q_Bi_Bj = Eigen::Quaterniond::Identity();
    Eigen::Vector3d p_Bi_Bj = Eigen::Vector3d::Zero();
    /// [theta p], theta on the right of q_Bi_Bj; includes the uncertainty of the given rotation.
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
    int inliers = 0;
};

/// Weighted least squares of  p_Bi = R Exp(theta) p_Bj + t  over the points that agree, theta with the rotation's
/// prior: t is first taken from single points, scored by truncated Mahalanobis distance, then refined over the points
/// within 99 % of chi^2. A point's covariance is the sum of those of its two places. Errors
/// common to all points, from rig and matching, are not in the covariance.
/// @param points    at most kMaxFeatures count; those with z <= 0 or not finite are left out
/// @param T_B_C     left camera to body
/// @param q_Bi_Bj   rotation of the body, from the gyroscope
/// @param out       written on kOk only
/// @return kDegenerate with fewer than 6 points or if less than half of them agree. Deterministic. Reentrant; about 70
///         KiB of stack. No heap.
Status estimate_stereo_motion(std::span<const StereoPoint> points, const Se3& T_B_C, const Eigen::Quaterniond& q_Bi_Bj,
                              const StereoMotionConfig& config, StereoMotion& out);

}  // namespace facet
