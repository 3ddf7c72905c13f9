// SPDX-License-Identifier: BSD-2-Clause
// How two poses of one body in one world differ.
#pragma once

#include <numbers>

#include "estimator/geometry/se3.h"

namespace facet {

/// For reports.
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// What leads from one pose to the other: q_to = q_from Exp(theta), p_to = p_from + p.
struct PoseDifference {
    Eigen::Vector3d theta = Eigen::Vector3d::Zero();  ///< in the body's axes (rad); no longer than pi
    Eigen::Vector3d p = Eigen::Vector3d::Zero();      ///< in the world's axes (m)

    double angle_deg() const { return theta.norm() * kDegPerRad; }
    double distance_m() const { return p.norm(); }
};

/// Rotations are normalised first. Reentrant. No heap.
PoseDifference pose_difference(const Se3& from, const Se3& to);

/// The turn about z (rad) that is nearest to a rotation R, or to a weighted sum of rotations: it maximises
/// trace(Rz(yaw)' R). 0 if every turn is as near.
double nearest_yaw(const Eigen::Matrix3d& R);

}  // namespace facet
