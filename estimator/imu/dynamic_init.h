// SPDX-License-Identifier: BSD-2-Clause
// The first state of a vehicle in motion: velocity, gravity and biases from preintegration and metric visual motion.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "estimator/imu/preintegration.h"
#include "estimator/imu/static_init.h"
#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Keyframes used in one initialization: 12 at 0.1 to 0.25 s are more than enough.
inline constexpr int kMaxInitKeyframes = 12;

/// Motion from one keyframe (k) to the next (j).
struct KeyframeMotion {
    Preintegration imu;                                 ///< from k to j; all motions at one bias
    Eigen::Vector3d p_Bk_Bj = Eigen::Vector3d::Zero();  ///< body at j seen from body at k, by vision, metric (m)
    Eigen::Matrix3d p_covariance = Eigen::Matrix3d::Identity();
    bool has_rotation = false;  ///< the two below are given
    Eigen::Quaterniond q_Bk_Bj = Eigen::Quaterniond::Identity();
    Eigen::Matrix3d theta_covariance = Eigen::Matrix3d::Identity();  ///< error on the right of q_Bk_Bj (rad^2)
};

/// Units, ranges and meanings: kDynamicInitFields below.
struct DynamicInitConfig {
    double gyro_bias_sigma_rad_per_s = 0.1;
    double accel_bias_sigma_m_per_s2 = 0.1;
    double max_velocity_sigma_m_per_s = 0.2;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kDynamicInitFields = std::to_array<ParameterField<DynamicInitConfig>>({
    {FACET_FIELD(DynamicInitConfig, gyro_bias_sigma_rad_per_s), "rad/s", 1e-5, 1,
     "Standard deviation of the gyroscope bias at which the motions are integrated."},
    {FACET_FIELD(DynamicInitConfig, accel_bias_sigma_m_per_s2), "m/s^2", 1e-3, 5,
     "Standard deviation of the accelerometer bias at which the motions are integrated; what of it stays unobserved "
     "tilts gravity, by 0.6 deg at 0.1 m/s^2."},
    {FACET_FIELD(DynamicInitConfig, max_velocity_sigma_m_per_s), "m/s", 1e-3, 10,
     "Largest standard deviation of the velocity with which it counts as observed."},
});

struct DynamicInit {
    InitialState initial;                 ///< at the LAST keyframe, its body the origin of W, yaw as in static_init.h
    double chi2_per_dof = 0.0;            ///< of the final residuals, expected 1
    double velocity_sigma_m_per_s = 0.0;  ///< largest axis, in the body frame: in W the tilt's error adds to it
    double gravity_norm_m_per_s2 = 0.0;   ///< before its magnitude was imposed
};

/// Unknowns: biases bg, ba; gravity g and the velocities u_0 .. u_n in the first body frame B0. With R_0k the product
/// of the gyroscope's rotations, T the interval and (dR, dp, dv) the deltas corrected for the biases, every motion k
/// gives
///   r_theta = Log(dR^T q_visual)                                      if vision gives the rotation
///   r_p     = p_visual - R_0k^T (u_k T + 1/2 g T^2) - dp
///   r_v     = R_0k^T (u_k+1 - u_k - g T) - dv
/// with the joint covariance of the deltas and of vision; the biases have priors. Stereo makes the positions metric, so
/// everything but bg is linear: Gauss-Newton first solves with g free, which must have the strength that the motions
/// carry (Preintegration) within its own uncertainty, then with |g| imposed, g turning in its tangent plane. The idea
/// is the linear alignment of [Qin18] Sec. V-B with known scale, and of [Martinelli14]; covariances are added, so that
/// the resulting prior is honest.
///
/// Observability: tilt and horizontal accelerometer bias can be separated only by rotation; without it the bias's prior
/// becomes part of the tilt's uncertainty. Standing still, constant velocity and free fall are not special cases. The
/// gyroscope's white noise along the chain R_0k is taken as independent from motion to motion, and so are positions
/// that share the image errors of a keyframe.
///
/// Usage: keep the last 4 to 12 keyframes over 0.5 to 2 s; call integrate_between() and estimate_stereo_motion() for
/// each pair; call this; on kOk start the window at the last keyframe with initial.state and initial.information(). If
/// the gyro bias has moved by more than 0.02 rad/s, integrate again at the new biases and call again for an exact
/// result.
///
/// @param motions  2 to kMaxInitKeyframes - 1, consecutive
/// @param out      written on kOk only
/// @return kInvalidArgument if there are fewer or more motions or one has no duration; kDegenerate if gravity or
///         velocity is known less well than the config requires, or a covariance is not positive definite: wait for
///         more motion; kCorrupt if vision and IMU contradict each other (|g|, chi^2): drop these keyframes. Reentrant.
///         No heap.
///
/// [Qin18] VINS-Mono, T-RO 2018.
/// [Martinelli14] Closed-form Solution of Visual-Inertial Structure from Motion, IJCV 2014.
Status initialize_in_motion(std::span<const KeyframeMotion> motions, const DynamicInitConfig& config, DynamicInit& out);

}  // namespace facet
