// SPDX-License-Identifier: BSD-2-Clause
// How a belief changes for other reasons than samples and images: rest, restarts, what earlier estimates knew.
#pragma once

#include "estimator/api/belief.h"

namespace facet {

// All functions: reentrant, no heap.

/// Of a covariance whose inverse exists.
StateCovariance inverse(const StateCovariance& covariance);

/// The vehicle stands where it stood at the newest keyframe: that is known better than the inertial prediction since,
/// which has the errors of velocity and biases.
void hold_at(const Belief& keyframe, Belief& now);

/// The vehicle stood when the images went, and the IMU has shown no motion since: it stays where it was, and may creep.
/// @param before   an earlier step of this @param blind_s  since the last frame
void hold_blind(const Belief& before, double blind_s, Belief& now);

/// Makes position and yaw as uncertain as a flight of which nothing is known may make them.
/// @param w_B  rate of the body when it was last known (rad/s)
void widen_after_unknown(const Eigen::Vector3d& w_B, double lost_s, Belief& belief);

/// Adds these standard deviations to those of the biases, in quadrature.
void widen_biases(double gyro_rad_per_s, double accel_m_per_s2, Belief& belief);

/// Corrects the state that a start has found by the biases of an earlier estimate, as two Gaussians are fused.
void fuse_biases(const Belief& earlier, Belief& now);

/// Gives a belief found without regard to the past its position and yaw: of `before` with their uncertainty, or the
/// origin. @param before  nullptr: the origin
void keep_place(const Belief* before, Belief& now);

/// Takes position and yaw for known: a choice of the window that begins here.
void fix_place(Belief& now);

/// A place and a yaw to restart from when the state itself is worthless: where the last estimate that was to be used
/// was, give or take what the vehicle may have flown since; the yaw is the gyroscope's, which is rarely at fault.
Belief salvage(const Belief& trusted, const Belief& now);

/// Biases as they were, independent of everything else.
void keep_biases(const Belief& before, Belief& now);

/// Replaces a worthless belief: levelled by the measured specific force, with yaw and position roughly kept, velocity
/// and biases forgotten. @param levelled  a state whose attitude is level @param kept  gives yaw and place
/// @param gyro_rad_per_s, accel_m_per_s2  standard deviations of the biases
void fall_back(const NavState& levelled, const Belief& kept, double gyro_rad_per_s, double accel_m_per_s2, Belief& now);

/// Beyond this a tilt is worth nothing: standard deviation (rad).
inline constexpr double kWorthlessTiltSigma_rad = 0.2;

}  // namespace facet
