// SPDX-License-Identifier: BSD-2-Clause
// The Gaussian prior on the oldest states of the window, which marginalization produces.
#pragma once

#include <Eigen/Core>
#include <array>

#include "estimator/geometry/plane.h"
#include "estimator/imu/preintegration.h"
#include "estimator/values/capacity.h"

namespace facet {

/// Quadratic prior on the parameters shared by all keyframes (the globals, first) and on the window's first keyframes,
/// about the points where they were linearized:
///   c(d) = g^T d + 1/2 d^T H d,   d_k = x_lin,k.box_minus_to(x_k), order [theta p v bg ba], 15 per keyframe.
/// First-estimate Jacobians: d changes one to one with the tangent of x_k, so the prior's Jacobian never changes and
/// its null space (yaw and position) is preserved. [Huang10], [Leutenegger15] Sec. 3.5
/// Thread-bound. No heap; 2.3 MB.
class PriorFactor {
public:
    /// Most globals: the calibration, heights of levels of the ground, and the planes.
    static constexpr int kMaxCalibration = 44;
    static constexpr int kMaxGround = 3;  ///< a floor, what stands on it, and the next one
    static constexpr int kMaxGlobals = kMaxCalibration + kMaxGround + kPlaneDim * kMaxPlanes;
    static constexpr int kMaxDim = kMaxGlobals + kMaxKeyframes * kStateDim;

    using Matrix = Eigen::Map<Eigen::MatrixXd, Eigen::Aligned64>;
    using ConstMatrix = Eigen::Map<const Eigen::MatrixXd, Eigen::Aligned64>;
    using Vector = Eigen::Map<Eigen::VectorXd, Eigen::Aligned64>;
    using ConstVector = Eigen::Map<const Eigen::VectorXd, Eigen::Aligned64>;

    /// Zeroes the prior over this many keyframes and globals.
    void reset(int keyframes, int globals = 0);
    int globals() const { return globals_; }
    int keyframes() const { return (dim_ - globals_) / kStateDim; }
    int dim() const { return dim_; }

    Matrix h() { return {h_.data(), dim_, dim_}; }
    ConstMatrix h() const { return {h_.data(), dim_, dim_}; }
    Vector g() { return {g_.data(), dim_}; }
    ConstVector g() const { return {g_.data(), dim_}; }

    /// Appends this many globals, about which the prior has no information.
    void append_globals(int count);

    /// Removes a plane, three globals from row `first` on, by the Schur complement: the coupling it makes between other
    /// parameters is kept. Directions of the plane in which the prior has no information are left out.
    void marginalize_plane(int first);

    /// Lets a global wander by a random step of this variance q, independent of all else: with its column h of H,
    ///   H' = H - h h^T q / (1 + q h_ii),   g' = g - h g_i q / (1 + q h_ii),
    /// the Schur complement over its value before the step. Directions without information keep none.
    void add_walk(int global, double variance);

    /// Moves keyframe 0's linearization point by its displacement d: g += H d in its block, with H and g transformed
    /// into the tangent there by Jr^-1(d_theta). Exact for the quadratic; only for a prior on one keyframe that is
    /// independent of the globals.
    void rebase_single(const Eigen::Matrix<double, kStateDim, 1>& d);

    /// Cost at displacement d, and H d + g into `gradient` (both of dimension dim()).
    double evaluate(const Eigen::Ref<const Eigen::VectorXd>& d, Eigen::Ref<Eigen::VectorXd> gradient) const;

private:
    int globals_ = 0;
    int dim_ = 0;
    alignas(64) std::array<double, static_cast<std::size_t>(kMaxDim) * kMaxDim> h_;
    alignas(64) std::array<double, kMaxDim> g_;
};

}  // namespace facet
