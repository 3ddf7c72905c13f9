// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/values/nav_state.h"

namespace facet {

NavState NavState::box_plus(const Eigen::Matrix<double, 15, 1>& d) const {
    NavState out;
    out.q_W_B = (q_W_B * so3_exp(d.segment<3>(kTheta))).normalized();
    out.p_W_B = p_W_B + d.segment<3>(kPos);
    out.v_W_B = v_W_B + d.segment<3>(kVel);
    out.bias.gyro = bias.gyro + d.segment<3>(kBiasGyro);
    out.bias.accel = bias.accel + d.segment<3>(kBiasAccel);
    return out;
}

Eigen::Matrix<double, 15, 1> NavState::box_minus_to(const NavState& other) const {
    Eigen::Matrix<double, 15, 1> d;
    d.segment<3>(kTheta) = so3_log(q_W_B.conjugate() * other.q_W_B);
    d.segment<3>(kPos) = other.p_W_B - p_W_B;
    d.segment<3>(kVel) = other.v_W_B - v_W_B;
    d.segment<3>(kBiasGyro) = other.bias.gyro - bias.gyro;
    d.segment<3>(kBiasAccel) = other.bias.accel - bias.accel;
    return d;
}

}  // namespace facet
