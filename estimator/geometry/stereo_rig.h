// SPDX-License-Identifier: BSD-2-Clause
// The calibrated sensor set of a vehicle: two cameras and one IMU.
#pragma once

#include "estimator/geometry/camera_model.h"
#include "estimator/geometry/se3.h"

namespace facet {

/// Two cameras rigidly mounted to the body (= IMU) frame, or one. Immutable during a run.
struct StereoRig {
    CameraModel left;
    CameraModel right;
    Se3 T_B_C0;  ///< left camera to body
    Se3 T_B_C1;  ///< right camera to body
    /// False: there is no right camera; no frame has a right image, and what is said of that camera is never used.
    bool has_right = true;

    /// Right from left: p_C1 = T_C1_C0 * p_C0.
    Se3 T_C1_C0() const { return T_B_C1.inverse() * T_B_C0; }
    double baseline_m() const { return (T_B_C1.p - T_B_C0.p).norm(); }

    /// The same cameras, left and right exchanged.
    StereoRig exchanged() const { return {right, left, T_B_C1, T_B_C0, has_right}; }
    /// A rig of one camera. Its right one, which is never used, is a copy 0.1 m beside it.
    static StereoRig monocular(const CameraModel& camera, const Se3& T_B_C) {
        return {camera, camera, T_B_C, T_B_C * Se3{Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0}}, false};
    }
};

}  // namespace facet
