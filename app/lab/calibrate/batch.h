// SPDX-License-Identifier: BSD-2-Clause
// The calibration that explains a whole flight best: all keyframes, points and cameras in one least-squares problem.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "app/lab/calibrate/recorded_flight.h"
#include "app/lab/calibrate/rig_parameters.h"
#include "estimator/imu/imu_limits.h"
#include "estimator/values/gravity.h"

namespace facet {

/// Rounds of solve_batch() at most: one that holds the calibration, three, and one after some of it is held.
inline constexpr std::size_t kBatchRounds = 5;

struct BatchOptions {
    RigAndTime given;
    RigVector prior_sigma = RigVector::Zero();  ///< 0: the entry does not exist
    ImuNoise noise;
    ImuLimits limits;
    GravityConfig gravity;
    std::function<void(std::size_t rounds)> progress;  ///< called after each with the number done; may be empty
};

/// Residual of one sighting: measured minus predicted.
struct SightingResidual {
    int camera = 0;  ///< 0 left, 1 right
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    Eigen::Vector2d error_px = Eigen::Vector2d::Zero();
};

struct BatchResult {
    RigVector correction = RigVector::Zero();
    RigVector sigma = RigVector::Zero();  ///< standard deviations, those kept as given included
    double pixel_sigma = 0.0;             ///< of one coordinate, robust (px)
    int keyframes = 0;
    int points = 0;
    int sightings = 0;                     ///< single images of points
    std::vector<SightingResidual> before;  ///< with the calibration as given, the flight fitted to it
    std::vector<SightingResidual> after;
};

/// Whether this build has a solver: it needs Ceres, which the vehicle does not.
bool has_batch_solver();

/// Minimises over the keyframes' states, the points, and the correction c of the calibration
///   sum rho(|pi(T_B_C(c)^-1 T_W_B(t_k + offset)^-1 p; lens(c)) - px|^2 / sigma_px^2)
///     + sum |r_imu|^2 + sum (c / sigma_c)^2
/// with rho Cauchy's loss, r_imu the preintegrated inertial factor of [Forster17] (estimator/factors/imu_factor.h), and
/// the prior of `prior_sigma`; position and yaw of the first keyframe are held. Between rounds, samples are integrated
/// again at the biases found, sigma_px follows from the residuals, and outliers go. Entries that the flight does not
/// show (ParameterVerdict::kNotObservable) are then held at 0 for a last round; their sigma is the one without holding.
/// Standard deviations come from the inverse of the whole problem's normal matrix, sightings weighted as dependent
/// along their track. Equal inputs give equal results: there is one thread.
/// @return kDegenerate if too little is left to solve, or the solver fails (out untouched); kInvalidArgument without a
///         solver. Heap. Reentrant.
Status solve_batch(const RecordedFlight& flight, const BatchOptions& options, BatchResult& out);

}  // namespace facet
