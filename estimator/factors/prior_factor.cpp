// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/prior_factor.h"

#include "platform/base/assert.h"

namespace facet {

void PriorFactor::reset(int keyframes) {
    FACET_ASSERT(keyframes >= 0 && keyframes <= kMaxKeyframes);
    dim_ = keyframes * kStateDim;
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

}  // namespace facet
