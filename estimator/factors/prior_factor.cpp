// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/prior_factor.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "platform/base/assert.h"

namespace facet {
namespace {

std::size_t index(int row, int column, int dim) {
    return static_cast<std::size_t>(column) * static_cast<std::size_t>(dim) + static_cast<std::size_t>(row);
}

}  // namespace

void PriorFactor::reset(int keyframes, int globals) {
    FACET_ASSERT(keyframes >= 0 && keyframes <= kMaxKeyframes && globals >= 0 && globals <= kMaxGlobals);
    globals_ = globals;
    dim_ = globals + keyframes * kStateDim;
    h().setZero();
    g().setZero();
}

void PriorFactor::append_globals(int count) {
    FACET_ASSERT(count >= 0 && globals_ + count <= kMaxGlobals);
    const int old_dim = dim_;
    const int first = globals_;
    globals_ += count;
    dim_ += count;
    // From the back, so that nothing is overwritten before it has moved.
    for (int column = old_dim - 1; column >= 0; --column) {
        for (int row = old_dim - 1; row >= 0; --row) {
            const int to_row = row < first ? row : row + count;
            const int to_column = column < first ? column : column + count;
            h_[index(to_row, to_column, dim_)] = h_[index(row, column, old_dim)];
        }
    }
    h().middleRows(first, count).setZero();
    h().middleCols(first, count).setZero();
    for (int row = old_dim - 1; row >= first; --row) {
        g_[static_cast<std::size_t>(row + count)] = g_[static_cast<std::size_t>(row)];
    }
    g().segment(first, count).setZero();
}

void PriorFactor::marginalize_plane(int first) {
    constexpr double kHeld = 1e-6;  // least information for a direction to count as constrained
    FACET_ASSERT(first >= 0 && first + kPlaneDim <= globals_);
    const Eigen::Matrix3d h_mm = h().block<kPlaneDim, kPlaneDim>(first, first);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(h_mm);
    Eigen::Matrix3d whitener;  // W with W W^T = H_mm^+
    for (int i = 0; i < kPlaneDim; ++i) {
        const double held = eigen.eigenvalues()(i);
        whitener.col(i) = (held > kHeld ? 1.0 / std::sqrt(held) : 0.0) * eigen.eigenvectors().col(i);
    }
    using Columns = Eigen::Matrix<double, Eigen::Dynamic, kPlaneDim, 0, kMaxDim, kPlaneDim>;
    const Columns a = h().middleCols<kPlaneDim>(first).lazyProduct(whitener);
    const Eigen::Vector3d g_white = whitener.transpose() * g().segment<kPlaneDim>(first);
    for (int column = 0; column < dim_; ++column) {
        h().col(column) -= a.lazyProduct(a.row(column).transpose());
    }
    g() -= a.lazyProduct(g_white);

    const int old_dim = dim_;
    globals_ -= kPlaneDim;
    dim_ -= kPlaneDim;
    // From the front, so that nothing is overwritten before it has moved.
    for (int column = 0; column < dim_; ++column) {
        const int from_column = column < first ? column : column + kPlaneDim;
        for (int row = 0; row < dim_; ++row) {
            const int from_row = row < first ? row : row + kPlaneDim;
            h_[index(row, column, dim_)] = h_[index(from_row, from_column, old_dim)];
        }
        g_[static_cast<std::size_t>(column)] = g_[static_cast<std::size_t>(from_column)];
    }
}

double PriorFactor::evaluate(const Eigen::Ref<const Eigen::VectorXd>& d, Eigen::Ref<Eigen::VectorXd> gradient) const {
    FACET_ASSERT(d.size() == dim_ && gradient.size() == dim_);
    gradient.noalias() = h() * d;
    const double cost = d.dot(g()) + 0.5 * d.dot(gradient);
    gradient += g();
    return cost;
}

void PriorFactor::add_walk(int global, double variance) {
    FACET_ASSERT(global >= 0 && global < globals_ && variance >= 0.0);
    const double share = variance / (1.0 + variance * h()(global, global));
    // The column is overwritten last: until then it is the factor of all others.
    const double g_old = g()(global);
    g() -= share * g_old * h().col(global);
    auto matrix = h();
    for (int j = 0; j < dim_; ++j) {
        if (j != global) {
            matrix.col(j) -= share * matrix(global, j) * matrix.col(global);
        }
    }
    matrix.col(global) *= 1.0 - share * matrix(global, global);
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
