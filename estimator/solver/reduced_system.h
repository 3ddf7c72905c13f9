// SPDX-License-Identifier: BSD-2-Clause
// The normal equations of the keyframes' states, after the landmarks are eliminated: fixed storage, dense.
#pragma once

#include <Eigen/Core>
#include <array>

#include "estimator/factors/prior_factor.h"
#include "estimator/factors/stereo_factor.h"
#include "estimator/imu/preintegration.h"
#include "estimator/values/capacity.h"
#include "platform/base/status.h"

namespace facet {

/// Parameters shared by all keyframes, first in the system: calibration, levels of the ground, planes.
inline constexpr int kMaxGlobals = PriorFactor::kMaxGlobals;
/// Largest dimension of the system: the globals and every keyframe's 15 parameters.
inline constexpr int kMaxSystemDim = kMaxGlobals + kMaxKeyframes * kStateDim;

/// H dx = -g over n = globals + 15 * keyframes parameters, H symmetric; only the lower triangle (row >= column) is kept
/// up to date. The globals come first; keyframe k owns 15 rows, starting at offset(k), order [theta p v bg ba].
/// Thread-bound. No heap; 2.3 MB.
class ReducedSystem {
public:
    using Matrix = Eigen::Map<Eigen::MatrixXd, Eigen::Aligned64>;
    using ConstMatrix = Eigen::Map<const Eigen::MatrixXd, Eigen::Aligned64>;
    using Vector = Eigen::Map<Eigen::VectorXd, Eigen::Aligned64>;
    using ConstVector = Eigen::Map<const Eigen::VectorXd, Eigen::Aligned64>;

    /// Zeroes the system for this many keyframes and globals.
    void reset(int keyframes, int globals = 0);
    /// The same for the gradient alone: h() keeps what it had, and must be left alone until the next reset().
    void reset_gradient(int keyframes, int globals = 0);
    bool has_matrix() const { return has_matrix_; }
    int globals() const { return globals_; }
    int keyframes() const { return (dim_ - globals_) / kStateDim; }
    int dim() const { return dim_; }
    /// First row of a keyframe.
    int offset(int keyframe) const { return globals_ + kStateDim * keyframe; }

    Matrix h() { return {h_.data(), dim_, dim_}; }
    ConstMatrix h() const { return {h_.data(), dim_, dim_}; }
    Vector g() { return {g_.data(), dim_}; }
    ConstVector g() const { return {g_.data(), dim_}; }

    /// Adds a state-to-state block (15x15) of keyframes i and j; i >= j.
    void add_state_block(int i, int j, const Eigen::Matrix<double, kStateDim, kStateDim>& block) {
        h().block<kStateDim, kStateDim>(offset(i), offset(j)) += block;
    }
    void add_state_gradient(int i, const Eigen::Matrix<double, kStateDim, 1>& gradient) {
        g().segment<kStateDim>(offset(i)) += gradient;
    }

private:
    bool has_matrix_ = true;
    int globals_ = 0;
    int dim_ = 0;
    alignas(64) std::array<double, static_cast<std::size_t>(kMaxSystemDim) * kMaxSystemDim> h_;
    alignas(64) std::array<double, kMaxSystemDim> g_;
};

/// Factorizes and solves damped reduced systems in its own storage. Thread-bound. No heap.
class ReducedSolver {
public:
    using Step = Eigen::Map<const Eigen::VectorXd, Eigen::Aligned64>;

    /// Solves (H + lambda * diag(H)) dx = -g by Cholesky.
    /// @return kDegenerate if the damped matrix is not positive definite (step() undefined).
    Status solve(const ReducedSystem& system, double lambda);

    /// Solves with the factor of the last solve(), which must have been undamped and of a system of the same dimension,
    /// for the gradient of this one. @return kDegenerate if the step is not finite (step() undefined).
    Status solve_again(const ReducedSystem& system);

    /// The last solution, dimension of the last system.
    Step step() const { return {step_.data(), dim_}; }

    /// Decrease of the quadratic model by the last step: -(g . dx + 1/2 dx^T H dx), >= 0.
    double predicted_decrease() const { return predicted_decrease_; }

    /// Marginal covariance (15x15) of the last keyframe of the last system solved with lambda = 0. [Golub13] Sec. 4.2
    Eigen::Matrix<double, kStateDim, kStateDim> last_keyframe_covariance() const;

    /// Joint marginal covariance (30x30) of the last two keyframes of that system, which must have as many.
    Eigen::Matrix<double, 2 * kStateDim, 2 * kStateDim> last_pair_covariance() const;

    /// Marginal variance of one parameter of the last system solved with lambda = 0. Overwrites step().
    double variance(int parameter);

    /// Marginal covariance of the parameters of single cameras in the last system solved with lambda = 0, which must
    /// have them. @param first  row of the first of them
    Eigen::Matrix<double, kCameraTermsDim, kCameraTermsDim> cameras_covariance(int first);

    /// Marginal covariance of the first parameters of the last system solved with lambda = 0, `count` square.
    /// Overwrites step(). @param count  at most PriorFactor::kMaxCalibration
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, PriorFactor::kMaxCalibration, PriorFactor::kMaxCalibration>
    leading_covariance(int count);

private:
    /// step(), and the decrease that an undamped model predicts of it, by the factor.
    Status substitute(const ReducedSystem& system);

    int dim_ = 0;
    double predicted_decrease_ = 0.0;
    alignas(64) std::array<double, static_cast<std::size_t>(kMaxSystemDim) * kMaxSystemDim> l_;
    alignas(64) std::array<double, kMaxSystemDim> step_;
    alignas(64) std::array<double, static_cast<std::size_t>(kMaxSystemDim) * PriorFactor::kMaxCalibration> columns_;
};

}  // namespace facet
