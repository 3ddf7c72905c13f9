// SPDX-License-Identifier: BSD-2-Clause
// The calibrated sensor set of a vehicle: two cameras and one IMU.
#pragma once

#include "estimator/geometry/camera_model.h"
#include "estimator/geometry/se3.h"

namespace facet {

/// Two cameras rigidly mounted to the body (= IMU) frame. Immutable during a run.
struct StereoRig {
    CameraModel left;
    CameraModel right;
    Se3 T_B_C0;  ///< left camera to body
    Se3 T_B_C1;  ///< right camera to body

    /// Right from left: p_C1 = T_C1_C0 * p_C0.
    Se3 T_C1_C0() const { return T_B_C1.inverse() * T_B_C0; }
    double baseline_m() const { return (T_B_C1.p - T_B_C0.p).norm(); }
};

}  // namespace facet
