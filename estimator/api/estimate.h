// SPDX-License-Identifier: BSD-2-Clause
// The state of the vehicle at one frame, how uncertain it is, and how far it can be trusted.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/se3.h"
#include "estimator/values/health.h"
#include "estimator/values/nav_state.h"
#include "estimator/window/rig_calibration.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Corrections of the calibration as given, and how well they are known.
struct CalibrationEstimate {
    RigCalibration correction;
    RigCalibration::Tangent sigma = RigCalibration::Tangent::Zero();  ///< 0 where not estimated
};

/// Estimate at one frame.
struct Estimate {
    Timestamp stamp;  ///< of the exposure in the IMU's clock: the frame's stamp plus the time offset known before it
    NavState state;
    /// Order [theta p v]: theta is a right perturbation in B (rad), p and v are in W (m, m/s). Counted from the last
    /// start: p and yaw are relative to their values there.
    Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();
    /// Correction of the cameras' pose on the body: T_B_Ck = T_B_Bc * (T_B_Ck as calibrated); identity if not
    /// estimated.
    Se3 T_B_Bc;
    Eigen::Matrix<double, 6, 1> T_B_Bc_sigma =
        Eigen::Matrix<double, 6, 1>::Zero();  ///< of [theta p]; 0 if not estimated
    Health health;
};

}  // namespace facet
