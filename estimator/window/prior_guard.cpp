// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/prior_guard.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr double kFirstShare = 1e-12;
constexpr double kShareStep = 100.0;
// Information below this is none: a parameter known to 30 km.
constexpr double kLeastInformation = 1e-9;

/// Adds a share of itself to every element of a matrix's diagonal.
template <class Matrix>
void raise_diagonal(double share, Matrix&& h) {
    for (double& information : h.diagonal()) {
        information += share * std::max(std::abs(information), kLeastInformation) + kLeastInformation;
    }
}

}  // namespace

bool is_plausible(const PriorFactor& prior) {
    return prior.h().allFinite() && prior.g().allFinite() && prior.h().diagonal().minCoeff() >= 0.0;
}

Status make_semidefinite(PriorFactor& prior, ReducedSystem& scratch) {
    if (!prior.h().allFinite() || !prior.g().allFinite()) {
        return Status::kDegenerate;
    }
    for (double share = kFirstShare; share <= 1.0; share *= kShareStep) {
        scratch.reset(prior.keyframes(), prior.globals());
        auto h = scratch.h();
        h.triangularView<Eigen::Lower>() = prior.h();
        raise_diagonal(share, h);
        Eigen::Ref<Eigen::MatrixXd> in_place(h);
        const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(in_place);
        if (llt.info() == Eigen::Success) {
            raise_diagonal(share, prior.h());
            return Status::kOk;
        }
    }
    return Status::kDegenerate;
}

Eigen::Matrix<double, kStateDim, 1> emergency_sigmas() {
    Eigen::Matrix<double, kStateDim, 1> sigmas;
    sigmas.segment<3>(kTheta).setConstant(0.05);
    sigmas.segment<3>(kPos).setConstant(0.1);
    sigmas.segment<3>(kVel).setConstant(0.3);
    sigmas.segment<3>(kBiasGyro).setConstant(0.02);
    sigmas.segment<3>(kBiasAccel).setConstant(0.1);
    return sigmas;
}

}  // namespace facet
