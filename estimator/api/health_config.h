// SPDX-License-Identifier: BSD-2-Clause
// Limits by which the estimator judges itself.
#pragma once

#include "platform/base/status.h"

namespace facet {

/// One line a field: meaning [unit] [range] and why this default.
struct HealthConfig {
    int few_features = 12;      ///< fewer tracked features do not hold a pose [4, 100]
    double lost_after_s = 3.0;  ///< without vision for longer: lost [0.2, 30]; inertial data then err by decimetres
    double max_speed_m_per_s = 20.0;            ///< faster is divergence [1, 100]
    double max_velocity_sigma_m_per_s = 0.5;    ///< a velocity less sure than this is none [0.05, 10]
    double max_gyro_bias_rad_per_s = 0.5;       ///< larger is divergence [0.01, 5]
    double max_accel_bias_m_per_s2 = 2.0;       ///< larger is divergence [0.1, 10]
    double high_vision_chi2 = 4.0;              ///< squared residual per degree of freedom: degraded [1, 100]
    double wrong_vision_chi2 = 25.0;            ///< likewise at three keyframes in a row: lost [2, 1000]
    double ready_velocity_sigma_m_per_s = 0.1;  ///< a start is over when velocity is known this well [0.01, 1]
    double ready_tilt_sigma_rad = 0.05;         ///< and the direction of gravity [0.001, 0.5]
    double grace_s = 2.0;                       ///< quality stays low for this long after a start [0, 30]
    double vibration_m_per_s2 = 3.0;            ///< shaking of the accelerometer worth a warning [0.1, 100]
    bool auto_reset = true;                     ///< begin anew, in flight, when lost and images are back

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

}  // namespace facet
