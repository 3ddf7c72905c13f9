// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/calibration_config.h"

#include <numbers>

#include "estimator/window/rig_calibration.h"

namespace facet {

int CalibrationConfig::dim() const {
    return estimate_cameras ? kCalibrationDim : (estimate_extrinsics ? kRigDim : (estimate_time_offset ? 1 : 0));
}

double CalibrationConfig::sigma(int parameter) const {
    constexpr double kUnwantedTimeOffset_s = 1e-7;
    if (parameter == kTimeOffset) {
        return estimate_time_offset ? time_offset_sigma_s : kUnwantedTimeOffset_s;
    }
    if (parameter < kRigPos) {
        return estimate_extrinsics ? rotation_sigma_rad : camera_rotation_sigma_rad;
    }
    if (parameter < kRigDim) {
        return estimate_extrinsics ? translation_sigma_m : camera_position_sigma_m;
    }
    if (parameter >= kRightTheta && parameter < kRightLens) {
        // Of two cameras with errors of their own, the difference.
        return std::numbers::sqrt2 * (parameter < kRightPos ? camera_rotation_sigma_rad : camera_position_sigma_m);
    }
    const int lens = parameter - (parameter < kRightTheta ? kLeftLens : kRightLens);
    if (lens < kLensDistortion) {
        return lens < kLensPrincipal ? focal_sigma : principal_sigma_px;
    }
    return lens < kLensDistortion + 2 ? distortion_sigma : late_distortion_sigma;
}

Status CalibrationConfig::validate() const { return validate_fields(kCalibrationFields, *this); }

}  // namespace facet
