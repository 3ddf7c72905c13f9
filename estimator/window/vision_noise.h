// SPDX-License-Identifier: BSD-2-Clause
// How precise the observations of landmarks are, learned from the window's own residuals.
#pragma once

#include <algorithm>
#include <cmath>

namespace facet {

/// Standard deviation that observations are weighted with: the root mean square s of a window's residuals, averaged,
///   sigma^2 <- sigma^2 + gain (s^2 - sigma^2),     once a keyframe,
/// gain 1/2, 1/3 and so on down to kLeastGain: a mean in which the configured value is the first, then one that forgets.
/// It stays within a factor of kReach of the configured value. Residuals have a narrow core and long tails; that the tails
/// raise sigma above the core's is meant: errors along a track are not independent. Thread-bound. No heap.
class VisionNoise {
public:
    static constexpr double kDependence = 1.5;
    static constexpr double kLeastGain = 0.1;  ///< ten keyframes: as long as half a window stays
    static constexpr double kReach = 10.0;
    static constexpr int kEnoughRows = 100;

    /// @param is_learned  false: the configured value stays
    void reset(double configured_px, bool is_learned) {
        configured_px_ = sigma_px_ = measured_px_ = configured_px;
        gain_ = 1.0;
        is_learned_ = is_learned;
    }

    /// Takes a window's residuals. Too few are no measurement.
    /// @param squared_error_px2  sum of squared residuals (px^2)
    /// @param rows               their number, less three a landmark
    void measure(double squared_error_px2, int rows) {
        if (rows >= kEnoughRows && std::isfinite(squared_error_px2)) {
            measured_px_ = std::sqrt(squared_error_px2 / rows);
        }
    }

    /// Moves the weights towards the last measurement.
    void learn() {
        if (is_learned_) {
            const double wanted = std::clamp(measured_px_, configured_px_ / kReach, configured_px_ * kReach);
            gain_ = std::max(kLeastGain, gain_ / (1.0 + gain_));  // 1/n to 1/(n + 1)
            sigma_px_ = std::sqrt(sigma_px_ * sigma_px_ + gain_ * (wanted * wanted - sigma_px_ * sigma_px_));
        }
    }

    double sigma_px() const { return sigma_px_; }        ///< for weights
    double measured_px() const { return measured_px_; }  ///< root mean square, outliers included
    /// What single landmarks should be judged by, tails and all: errors along a track are not independent, so that n
    /// observations say less than n independent ones.
    double cautious_px() const { return is_learned_ ? kDependence * measured_px_ : sigma_px_; }
    double configured_px() const { return configured_px_; }

private:
    double configured_px_ = 1.0;
    double sigma_px_ = 1.0;
    double measured_px_ = 1.0;
    double gain_ = 1.0;
    bool is_learned_ = false;
};

}  // namespace facet
