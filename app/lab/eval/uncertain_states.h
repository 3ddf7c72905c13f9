// SPDX-License-Identifier: BSD-2-Clause
// Estimated states with their reported covariance, read from its files.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimator/geometry/se3.h"
#include "platform/base/timestamp.h"

namespace facet {

inline constexpr int kClaimDim = 9;  ///< [theta p v], 3 each
using ClaimVector = Eigen::Matrix<double, kClaimDim, 1>;
using ClaimMatrix = Eigen::Matrix<double, kClaimDim, kClaimDim>;

/// One estimate. The covariance is that of the tangent [theta p v]: theta turns on the right of q_W_B (rad), p and v
/// add in the estimate's world (m, m/s).
struct UncertainState {
    Timestamp stamp;
    Se3 T_W_B;
    Eigen::Vector3d v_W_B = Eigen::Vector3d::Zero();
    ClaimMatrix covariance = ClaimMatrix::Zero();
};

/// Joins trajectory.csv (EuRoC's 17 columns) and covariance.csv: stamp_ns and the 45 entries c00, c01, ... c88 of the
/// upper triangle, row by row. Rows of one file without a partner in the other are left out. Throws InputError with
/// file and line for a row of covariance.csv that is not 46 numbers, or if a file cannot be read.
std::vector<UncertainState> read_uncertain_states(const std::string& trajectory_csv, const std::string& covariance_csv);

}  // namespace facet
