// SPDX-License-Identifier: BSD-2-Clause
// How good the given calibration of the cameras is, as a whole.
#pragma once

#include <Eigen/Core>

#include "estimator/factors/stereo_factor.h"
#include "estimator/window/calibration_prior.h"

namespace facet {

/// Learns one factor K on all standard deviations of the given calibration. Who calibrates well does so in all
/// parameters, so that those which a flight shows, such as the principal points, predict those that it
/// hardly does, such as the baseline: an empirical Bayes prior. With n parameters, corrections c, their covariance C
/// after the optimization and that of what was given, K^2 P, a step of expectation maximization [Dempster77] is
///   K^2 = (m + c^T P^-1 c + tr(P^-1 C)) / (m + n):
/// parameters of which nothing is seen leave K as it is, and m = 1 parameters that are as good as stated stand for what
/// is thought of K before. K is held between 1/5 and 5. Thread-bound. No heap.
class CalibrationQuality {
public:
    using Correction = Eigen::Matrix<double, kCameraTermsDim, 1>;
    using Covariance = Eigen::Matrix<double, kCameraTermsDim, kCameraTermsDim>;

    /// Begins with K = 1. @param given  covariance of the calibration as given, with the parameters of single cameras
    void reset(const CalibrationMatrix& given);
    /// Goes back to K = 1.
    void forget() { squared_scale_ = 1.0; }
    void learn(const Correction& correction, const Covariance& covariance);

    /// K.
    double scale() const;
    /// The information of what was given, for the present K. @param information  for K = 1
    /// @param first  of the parameters that K applies to, up to those of the IMU
    CalibrationMatrix scaled(const CalibrationMatrix& information, int first) const;

private:
    Covariance given_information_ = Covariance::Identity();
    double squared_scale_ = 1.0;
};

}  // namespace facet
