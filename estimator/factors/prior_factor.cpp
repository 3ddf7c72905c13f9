// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/prior_factor.h"

#include "platform/base/assert.h"

namespace facet {

void PriorFactor::reset(int keyframes, int globals) {
    FACET_ASSERT(keyframes >= 0 && keyframes <= kMaxKeyframes && globals >= 0 && globals <= kMaxGlobals);
    globals_ = globals;
    dim_ = globals + keyframes * kStateDim;
    h().setZero();
    g().setZero();
}

double PriorFactor::evaluate(const Eigen::Ref<const Eigen::VectorXd>& d, Eigen::Ref<Eigen::VectorXd> gradient) const {
    FACET_ASSERT(d.size() == dim_ && gradient.size() == dim_);
    gradient.noalias() = h() * d;
    const double cost = d.dot(g()) + 0.5 * d.dot(gradient);
    gradient += g();
    return cost;
}

void PriorFactor::rebase_single(const Eigen::Matrix<double, kStateDim, 1>& d) {
    using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;
    FACET_ASSERT(keyframes() == 1);
    StateMatrix jacobian = StateMatrix::Identity();
    jacobian.block<3, 3>(kTheta, kTheta) = so3_right_jacobian_inverse(d.segment<3>(kTheta));
    const StateMatrix h_old = h().bottomRightCorner<kStateDim, kStateDim>();
    const Eigen::Matrix<double, kStateDim, 1> g_old = g().tail<kStateDim>();
    g().tail<kStateDim>() = jacobian.transpose() * (g_old + h_old * d);
    h().bottomRightCorner<kStateDim, kStateDim>() = jacobian.transpose() * h_old * jacobian;
}

}  // namespace facet
