// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/rest_factor.h"

namespace facet {

void linearize_rest(const NavState& i, const NavState& j, const NavState& i_lin, const NavState& j_lin,
                    const RestSigmas& sigmas, RestFactorLinearization& out) {
    constexpr int kTurn = 0;
    constexpr int kMove = 3;
    constexpr int kSpeed = 6;
    out.r.segment<3>(kTurn) = so3_log(i.q_W_B.conjugate() * j.q_W_B) / sigmas.theta_rad;
    out.r.segment<3>(kMove) = i.q_W_B.conjugate() * (j.p_W_B - i.p_W_B) / sigmas.p_m;
    out.r.segment<3>(kSpeed) = j.v_W_B / sigmas.v_m_per_s;

    const Eigen::Quaterniond q_Bi_Bj = i_lin.q_W_B.conjugate() * j_lin.q_W_B;
    const Eigen::Matrix3d R_Bi_W = i_lin.q_W_B.toRotationMatrix().transpose();
    const Eigen::Matrix3d inverse_right = so3_right_jacobian_inverse(so3_log(q_Bi_Bj));
    out.d_r_d_i.setZero();
    out.d_r_d_j.setZero();
    out.d_r_d_i.block<3, 3>(kTurn, kTheta) = -inverse_right * q_Bi_Bj.toRotationMatrix().transpose() / sigmas.theta_rad;
    out.d_r_d_j.block<3, 3>(kTurn, kTheta) = inverse_right / sigmas.theta_rad;
    out.d_r_d_i.block<3, 3>(kMove, kTheta) = skew(R_Bi_W * (j_lin.p_W_B - i_lin.p_W_B)) / sigmas.p_m;
    out.d_r_d_i.block<3, 3>(kMove, kPos) = -R_Bi_W / sigmas.p_m;
    out.d_r_d_j.block<3, 3>(kMove, kPos) = R_Bi_W / sigmas.p_m;
    out.d_r_d_j.block<3, 3>(kSpeed, kVel) = Eigen::Matrix3d::Identity() / sigmas.v_m_per_s;
}

}  // namespace facet
