// SPDX-License-Identifier: BSD-2-Clause
// Which part of the errors the ground truth itself explains: its clock, and the point and axes of its body.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>

#include "app/lab/eval/trajectory.h"
#include "drivers/replay_asl/ground_truth.h"

namespace facet {

/// A fitted number with its standard deviation.
struct Fitted {
    double value = 0.0;
    double sigma = 0.0;

    /// The value if it differs from zero by three sigma, else zero.
    double shown() const { return std::abs(value) > 3.0 * sigma ? value : 0.0; }
};

/// The same for each axis of the body.
struct FittedVector {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    Eigen::Vector3d sigma = Eigen::Vector3d::Zero();

    /// The same, of all axes if one of them differs.
    Eigen::Vector3d shown() const {
        const bool is_shown = (value.array().abs() > 3.0 * sigma.array()).any();
        return is_shown ? value : Eigen::Vector3d::Zero();
    }
};

/// What fits the estimate to the ground truth best, beside the alignment of the two worlds. Positions and orientations
/// have lags of their own, because in many ground truths they are of different instruments.
struct TruthFit {
    bool is_known = false;         ///< the vehicle moves enough to tell
    Fitted lag_s;                  ///< estimate(t) fits the true position of t + lag: positive if the truth is late
    FittedVector lever_arm_m;      ///< from the point whose positions the truth gives to the body's origin, in its axes
    Fitted scale;                  ///< by which the estimate is multiplied; the estimator's, never the truth's
    Fitted orientation_lag_s;      ///< as lag_s, of the orientations
    FittedVector turn_rad;         ///< from the truth's body axes to the estimate's
    double position_rmse_m = 0.0;  ///< of what all of it leaves
    double orientation_rmse_rad = 0.0;
    /// Of that, what differs from its own mean over a second. Rendered flights, whose truth is exact, have about 0.9 mm
    /// and 1.3 mrad; more is the truth's.
    double position_swift_rmse_m = 0.0;
    double orientation_swift_rmse_rad = 0.0;
};

/// Two linear least squares problems, with the SE(3) alignment T, the true positions' centre c, and d, e, f, g for what
/// T leaves of itself:
///   positions     T p_est - p_true = lag v_true + R_true lever_arm - (scale - 1) (p_true - c) + d x (p_true - c) + e
///   orientations  Log(q_true^-1 T q_est) = orientation_lag w_true + turn + R_true^T f
/// Velocities are central differences of the true poses. Standard deviations are those of the residuals' variance times
/// their integrated autocorrelation time, since neighbouring errors are alike: sigma^2 = s^2 tau (J'J)^-1. What the
/// flight does not show has a large one and a value near zero.
/// Not known if there are fewer than thirty poses with neighbours within a quarter of a second, or the true path is
/// shorter than a metre. Heap. Reentrant.
TruthFit fit_truth(std::span<const PosePair> pairs);

/// The ground truth as it would be with the fit's clock, point and axes of the body, as far as the flight shows them:
/// an error of the estimate must not be taken for one of the truth. The scale is left alone.
/// Velocities, if known, are those of that point. States whose shifted stamps lie outside the truth are left out. Heap.
/// Reentrant.
std::vector<GroundTruthState> with_fit(std::span<const GroundTruthState> truth, const TruthFit& fit);

}  // namespace facet
