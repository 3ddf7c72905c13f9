// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/inertial_error.h"

#include "estimator/geometry/so3.h"

namespace facet {
namespace {

Eigen::Vector3d rate_error(const NavState& i, const NavState& j, const Preintegration& ij) {
    Eigen::Quaterniond dq;
    Eigen::Vector3d dp;
    Eigen::Vector3d dv;
    ij.corrected(i.bias, dq, dp, dv);
    return so3_log((i.q_W_B.conjugate() * j.q_W_B).conjugate() * dq) / ij.dt_s();
}

}  // namespace

ImuBias inertial_error(const NavState& i, const NavState& j, const Preintegration& ij) {
    const double h = ij.dt_s();
    if (!(h > 0.0)) {
        return {};
    }
    const Eigen::Vector3d off_W = ij.predict(i).p_W_B - j.p_W_B;
    return {rate_error(i, j, ij), i.q_W_B.conjugate() * off_W * (2.0 / (h * h))};
}

ImuBias inertial_error(const NavState& i, const NavState& j, const NavState& k, const Preintegration& ij,
                       const Preintegration& jk) {
    const double h_ij = ij.dt_s();
    const double h_jk = jk.dt_s();
    if (!(h_ij > 0.0) || !(h_jk > 0.0)) {
        return {};
    }
    // The velocity at i with which the first interval ends at j, and what it becomes there.
    NavState begin = i;
    begin.v_W_B += (j.p_W_B - ij.predict(i).p_W_B) / h_ij;
    NavState middle = j;
    middle.v_W_B = ij.predict(begin).v_W_B;
    const Eigen::Vector3d off_W = jk.predict(middle).p_W_B - k.p_W_B;
    return {rate_error(j, k, jk), j.q_W_B.conjugate() * off_W * (2.0 / (h_jk * (h_ij + h_jk)))};
}

}  // namespace facet
