// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/solver/reduced_system.h"

#include <Eigen/Cholesky>

#include "platform/base/assert.h"

namespace facet {
namespace {

/// Last kDim rows and columns of (L L^T)^-1: they need only those of L.
template <int kDim>
Eigen::Matrix<double, kDim, kDim> last_covariance(const Eigen::Map<const Eigen::MatrixXd, Eigen::Aligned64>& l) {
    FACET_ASSERT(l.rows() >= kDim);
    const Eigen::Matrix<double, kDim, kDim> corner = l.bottomRightCorner<kDim, kDim>();
    const Eigen::Matrix<double, kDim, kDim> inverse =
        corner.template triangularView<Eigen::Lower>().solve(Eigen::Matrix<double, kDim, kDim>::Identity());
    return inverse.transpose() * inverse;
}

}  // namespace

void ReducedSystem::reset(int keyframes, int globals) {
    reset_gradient(keyframes, globals);
    has_matrix_ = true;
    h().setZero();
}

void ReducedSystem::reset_gradient(int keyframes, int globals) {
    FACET_ASSERT(keyframes >= 0 && keyframes <= kMaxKeyframes && globals >= 0 && globals <= kMaxGlobals);
    globals_ = globals;
    dim_ = globals + keyframes * kStateDim;
    g().setZero();
    has_matrix_ = false;
}

Status ReducedSolver::solve(const ReducedSystem& system, double lambda) {
    dim_ = system.dim();
    Eigen::Map<Eigen::MatrixXd, Eigen::Aligned64> l(l_.data(), dim_, dim_);
    l.triangularView<Eigen::Lower>() = system.h();
    l.diagonal() += lambda * system.h().diagonal();
    Eigen::Ref<Eigen::MatrixXd> l_ref(l);
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(l_ref);
    if (llt.info() != Eigen::Success) {
        return Status::kDegenerate;
    }
    FACET_TRY(substitute(system));
    // (H + lambda D) dx = -g, so g.dx + 1/2 dx'H dx = 1/2 (g.dx - lambda dx'D dx).
    if (lambda > 0.0) {
        predicted_decrease_ += 0.5 * lambda * this->step().cwiseAbs2().dot(system.h().diagonal());
    }
    return Status::kOk;
}

Status ReducedSolver::solve_again(const ReducedSystem& system) {
    FACET_ASSERT(system.dim() == dim_);
    return substitute(system);
}

Status ReducedSolver::substitute(const ReducedSystem& system) {
    const Eigen::Map<const Eigen::MatrixXd, Eigen::Aligned64> l(l_.data(), dim_, dim_);
    Eigen::Map<Eigen::VectorXd, Eigen::Aligned64> step(step_.data(), dim_);
    step = -system.g();
    l.triangularView<Eigen::Lower>().solveInPlace(step);
    l.triangularView<Eigen::Lower>().adjoint().solveInPlace(step);
    if (!step.allFinite()) {
        return Status::kDegenerate;
    }
    predicted_decrease_ = -0.5 * system.g().dot(step);
    return Status::kOk;
}

Eigen::Matrix<double, kStateDim, kStateDim> ReducedSolver::last_keyframe_covariance() const {
    return last_covariance<kStateDim>(Eigen::Map<const Eigen::MatrixXd, Eigen::Aligned64>(l_.data(), dim_, dim_));
}

Eigen::Matrix<double, 2 * kStateDim, 2 * kStateDim> ReducedSolver::last_pair_covariance() const {
    return last_covariance<2 * kStateDim>(Eigen::Map<const Eigen::MatrixXd, Eigen::Aligned64>(l_.data(), dim_, dim_));
}

double ReducedSolver::variance(int parameter) {
    // e' (L L^T)^-1 e = |L^-1 e|^2.
    FACET_ASSERT(parameter >= 0 && parameter < dim_);
    const Eigen::Map<const Eigen::MatrixXd, Eigen::Aligned64> l(l_.data(), dim_, dim_);
    Eigen::Map<Eigen::VectorXd, Eigen::Aligned64> step(step_.data(), dim_);
    step.setZero();
    step(parameter) = 1.0;
    l.triangularView<Eigen::Lower>().solveInPlace(step);
    return step.squaredNorm();
}

Eigen::Matrix<double, kCameraTermsDim, kCameraTermsDim> ReducedSolver::cameras_covariance(int first) {
    // E' (L L^T)^-1 E = X'X with L X = E, by forward substitution; X lies transposed, so that its rows are contiguous.
    // Rows above E's ones are zero. Eigen's blocked solve would take its panels from the heap.
    const int rows = dim_ - first;
    FACET_ASSERT(first >= 0 && rows >= kCameraTermsDim);
    const Eigen::Map<const Eigen::MatrixXd, Eigen::Aligned64> l(l_.data(), dim_, dim_);
    Eigen::Map<Eigen::Matrix<double, kCameraTermsDim, Eigen::Dynamic>, Eigen::Aligned64> x_t(columns_.data(),
                                                                                             kCameraTermsDim, rows);
    x_t.setIdentity();
    Eigen::Matrix<double, kCameraTermsDim, kCameraTermsDim> covariance =
        Eigen::Matrix<double, kCameraTermsDim, kCameraTermsDim>::Zero();
    for (int j = 0; j < rows; ++j) {
        x_t.col(j) /= l(first + j, first + j);
        for (int i = j + 1; i < rows; ++i) {
            x_t.col(i) -= l(first + i, first + j) * x_t.col(j);
        }
        covariance.noalias() += x_t.col(j) * x_t.col(j).transpose();
    }
    return covariance;
}

Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, PriorFactor::kMaxCalibration, PriorFactor::kMaxCalibration>
ReducedSolver::leading_covariance(int count) {
    // As variance(), with the columns L^-1 e_i kept.
    FACET_ASSERT(count >= 0 && count <= PriorFactor::kMaxCalibration && count <= dim_);
    const Eigen::Map<const Eigen::MatrixXd, Eigen::Aligned64> l(l_.data(), dim_, dim_);
    Eigen::Map<Eigen::MatrixXd, Eigen::Aligned64> x(columns_.data(), dim_, count);
    for (int i = 0; i < count; ++i) {
        Eigen::Map<Eigen::VectorXd, Eigen::Aligned64> step(step_.data(), dim_);
        step.setZero();
        step(i) = 1.0;
        l.triangularView<Eigen::Lower>().solveInPlace(step);
        x.col(i) = step;
    }
    return x.transpose().lazyProduct(x);
}

}  // namespace facet
