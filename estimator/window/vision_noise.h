// SPDX-License-Identifier: BSD-2-Clause
// How precise the observations of landmarks are, learned from the window's own residuals.
#pragma once

#include <algorithm>
#include <cmath>

#include "estimator/geometry/robust_loss.h"

namespace facet {

/// Scale of residuals and weight of observations, both learned. At each keyframe either variance v follows the measured
/// one,
///   v <- v + gain (measured - v),
/// gain 1/2, 1/3 and so on down to kLeastGain: at first a mean that includes the configured value as its first element,
/// later a mean that forgets. Both stay within a factor of kReach of the configured value.
///
/// scale_px: robust standard deviation of the residuals, which a minority of outliers hardly moves; it sets the width
/// of the robust loss.
///
/// sigma_px: the standard deviation that a weight of one stands for. The points of an M-estimate have the covariance
/// E[psi^2] / E[psi']^2 times (J^T J)^-1 [Huber64]; the normal equations give sigma^2 / E[rho'] times that. To make
/// both agree,
///   sigma^2 = kDependence E[rho'] E[psi^2] / E[psi']^2,     psi of a coordinate, in pixels.
/// kDependence: errors along a track are not independent; n observations count as n / kDependence independent ones.
/// Measured against the truth, the error of a track keeps 0.77 of itself over 5 frames, 0.6 over half a second and 0.25
/// over three; that of its stereo match 0.35 throughout. Its value makes the covariance agree with the errors of two
/// simulated flights of 120 s, with and without errors of the calibration.
/// Thread-bound. No heap.
class VisionNoise {
public:
    static constexpr double kDependence = 4.0;
    static constexpr double kCaution = 1.5;
    static constexpr double kLeastGain = 0.1;  ///< ten keyframes: as long as half a window stays
    static constexpr double kReach = 10.0;
    static constexpr int kEnoughRows = 100;

    /// @param is_learned  false: the configured value is kept
    void reset(double configured_px, bool is_learned) {
        configured_px_ = sigma_px_ = scale_px_ = measured_px_ = measured_sigma_px_ = configured_px;
        measured_scale_px_ = configured_px;
        gain_ = 1.0;
        is_learned_ = is_learned;
    }

    /// Takes a window's residuals; too few are ignored.
    /// @param squared_error_px2  sum of squared residuals (px^2)
    /// @param rows               their number, minus three per landmark
    /// @param scale_px           their robust standard deviation
    /// @param loss               their sums under the loss, whitened by sigma_px()
    void measure(double squared_error_px2, int rows, double scale_px, const LossSums& loss) {
        if (rows < kEnoughRows || !std::isfinite(squared_error_px2) || !std::isfinite(scale_px)) {
            return;
        }
        measured_scale_px_ = scale_px;
        measured_px_ = std::sqrt(squared_error_px2 / rows);
        // E[rho'] E[psi^2] / E[psi']^2: the numbers of points cancel, except for the rows taken by the landmarks.
        const double variance =
            loss.weight * loss.squared_influence / (loss.slope * loss.slope) * loss.points / static_cast<double>(rows);
        if (std::isfinite(variance)) {
            measured_sigma_px_ = sigma_px_ * std::sqrt(kDependence * variance);
        }
    }

    /// Moves scale and weights towards the last measurement.
    void learn() {
        if (is_learned_) {
            gain_ = std::max(kLeastGain, gain_ / (1.0 + gain_));  // 1/n to 1/(n + 1)
            follow(measured_scale_px_, scale_px_);
            follow(measured_sigma_px_, sigma_px_);
        }
    }

    double sigma_px() const { return sigma_px_; }        ///< for weights
    double scale_px() const { return scale_px_; }        ///< for the loss
    double measured_px() const { return measured_px_; }  ///< root mean square at the last measurement
    /// Standard deviation for judging single landmarks, tails included: errors along a track are not independent, so
    /// that n observations say less than n independent ones.
    double cautious_px() const { return is_learned_ ? kCaution * measured_px_ : sigma_px_; }
    double configured_px() const { return configured_px_; }

private:
    void follow(double measured_px, double& px) const {
        const double wanted = std::clamp(measured_px, configured_px_ / kReach, configured_px_ * kReach);
        px = std::sqrt(px * px + gain_ * (wanted * wanted - px * px));
    }

    double configured_px_ = 1.0;
    double sigma_px_ = 1.0;
    double scale_px_ = 1.0;
    double measured_px_ = 1.0;
    double measured_sigma_px_ = 1.0;
    double measured_scale_px_ = 1.0;
    double gain_ = 1.0;
    bool is_learned_ = false;
};

}  // namespace facet
