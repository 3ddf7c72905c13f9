// SPDX-License-Identifier: BSD-2-Clause
// The inertial factor between two consecutive keyframes, bias random walk included.
#pragma once

#include <Eigen/Core>

#include "estimator/imu/preintegration.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/nav_state.h"

namespace facet {

/// Whitened residual and Jacobians of an inertial factor.
struct ImuFactorLinearization {
    Eigen::Matrix<double, 15, 1> r;
    Eigen::Matrix<double, 15, 15> d_r_d_i;
    Eigen::Matrix<double, 15, 15> d_r_d_j;
    Eigen::Matrix<double, 15, ImuScale::kDim> d_r_d_scale;  ///< only if the preintegration differentiates it
};

/// Inertial residual, order [theta p v bg ba].   [Forster17] eq. (45), bias walk eq. (48)
///   r_theta = Log(dR(bg_i)^T R_i^T R_j)
///   r_p     = R_i^T (p_j - p_i - v_i dt - 1/2 g dt^2) - dp(b_i)
///   r_v     = R_i^T (v_j - v_i - g dt) - dv(b_i)
///   r_b     = b_j - b_i
/// where the deltas follow the scale of the IMU's axes as they follow the bias,
/// with the gravity of the preintegration,
/// whitened by the square-root information of blockdiag(preintegrated covariance, walk^2 dt). Reentrant. No heap.
class ImuFactor {
public:
    ImuFactor() = default;
    /// @return kDegenerate if no time has passed or the covariance is not positive definite (object untouched).
    Status set(const Preintegration& preintegration, const ImuNoise& noise);

    const Preintegration& preintegration() const { return preintegration_; }

    /// @param scale  of the IMU's axes; nullptr: as integrated
    Eigen::Matrix<double, 15, 1> residual(const NavState& i, const NavState& j, const ImuScale* scale = nullptr) const;

    /// Residual at (i, j), Jacobians at the linearization points (i_lin, j_lin): first-estimate Jacobians where a state
    /// is bound by the prior; pass the same states twice otherwise.
    void linearize(const NavState& i, const NavState& j, const NavState& i_lin, const NavState& j_lin,
                   ImuFactorLinearization& out, const ImuScale* scale = nullptr) const;

private:
    Preintegration preintegration_;
    Eigen::Matrix<double, 15, 15> sqrt_information_ = Eigen::Matrix<double, 15, 15>::Identity();
};

}  // namespace facet
