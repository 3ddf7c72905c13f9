// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/ground_factor.h"

namespace facet {

GroundHeight linearize_ground_height(const NavState& state, const NavState& lin, const Eigen::Vector3d& m_B) {
    GroundHeight out;
    out.height_m = state.p_W_B.z() + (state.q_W_B * m_B).z();
    const Eigen::Vector3d up_B = lin.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    out.d_height_d_pose.head<3>() = m_B.cross(up_B).transpose();  // -up . [m]x dtheta = (m x up) . dtheta
    out.d_height_d_pose.tail<3>() = Eigen::RowVector3d::UnitZ();
    return out;
}

}  // namespace facet
