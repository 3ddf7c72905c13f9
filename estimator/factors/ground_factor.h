// SPDX-License-Identifier: BSD-2-Clause
// The height of the ground under the vehicle, as a range finder has found it from one keyframe.
#pragma once

#include <Eigen/Core>

#include "estimator/values/nav_state.h"

namespace facet {

/// Height and Jacobian; that with respect to velocity and biases is zero.
struct GroundHeight {
    double height_m = 0.0;                        ///< in W
    Eigen::Matrix<double, 1, 6> d_height_d_pose;  ///< order [theta p] (m/rad, 1)
};

/// Height of a point of the ground that is given in the body, m:
///   h = e_z . (p + R m),   dh = e_z . dp - e_z . R [m]x dtheta
/// A tilted beam is thus as long as it is. Neither a turn about the vertical nor a step sideways changes h, at any
/// linearization point. @param lin  where the Jacobian is evaluated. Reentrant. No heap.
GroundHeight linearize_ground_height(const NavState& state, const NavState& lin, const Eigen::Vector3d& m_B);

}  // namespace facet
