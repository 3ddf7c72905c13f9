// SPDX-License-Identifier: BSD-2-Clause
// Limits by which the estimator judges itself.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kHealthFields below.
struct HealthConfig {
    /// With a standard deviation of the velocity above this the estimate is degraded; above twice this for a while,
    /// lost (m/s).
    static constexpr double kMaxVelocitySigma_m_per_s = 0.5;
    /// The reported quality stays low for this time after a start (s).
    static constexpr double kGrace_s = 2.0;
    /// An estimated accelerometer bias above this is divergence: lost (m/s^2).
    static constexpr double kMaxAccelBias_m_per_s2 = 2.0;
    /// Squared vision residuals per degree of freedom above this at three keyframes in a row are divergence: lost.
    static constexpr double kWrongVisionChi2 = 25.0;
    /// With fewer tracked features than this a frame does not hold the pose: degraded.
    static constexpr int kFewFeatures = 12;
    /// Residuals of an image coordinate whose mean is off zero by more than this contradict the calibration: a warning,
    /// and half the quality at most (px).
    static constexpr double kMaxResidualBias_px = 0.015;
    /// A parameter of the calibration corrected by more than this, in standard deviations of what was given, is the
    /// same.
    static constexpr double kMaxCalibrationStretch = 4.0;
    /// With squared residuals of vision, or of the newest inertial factor, per degree of freedom above this the
    /// estimate is degraded. Not among the parameters.
    double high_vision_chi2 = 4.0;
    double lost_after_s = 3.0;
    double max_speed_m_per_s = 20.0;
    bool auto_reset = true;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kHealthFields = std::to_array<ParameterField<HealthConfig>>({
    {FACET_FIELD(HealthConfig, lost_after_s), "s", 0.2, 30,
     "After this time without vision the estimator is lost; by then inertial data alone err by decimetres."},
    {FACET_FIELD(HealthConfig, max_speed_m_per_s), "m/s", 1, 100, "An estimated speed above this is divergence: lost."},
    {FACET_FIELD(HealthConfig, auto_reset), "-", 0, 1,
     "Start again by itself, also in flight, when the estimator is lost and images are usable again."},
});

}  // namespace facet
