// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/calibration_config.h"

#include <cmath>
#include <numbers>

#include "estimator/window/rig_calibration.h"

namespace facet {
namespace {

constexpr double kUnwantedSigma = 1e-7;  // holds a parameter in place, whatever its unit

}  // namespace

int CalibrationConfig::dim() const {
    if (estimate_imu) {
        return kCalibrationDim;
    }
    return estimate_cameras ? kImuScale : (estimate_extrinsics ? kRigDim : (estimate_time_offset ? 1 : 0));
}

double CalibrationConfig::sigma(int parameter) const {
    if (parameter == kTimeOffset) {
        return estimate_time_offset ? time_offset_sigma_s : kUnwantedSigma;
    }
    if (parameter < kRigDim) {
        const bool turns = parameter < kRigPos;
        const double as_one = turns ? rotation_sigma_rad : translation_sigma_m;
        const double of_left = turns ? camera_rotation_sigma_rad : camera_position_sigma_m;
        if (!estimate_cameras) {
            return estimate_extrinsics ? as_one : kUnwantedSigma;
        }
        return estimate_extrinsics ? std::hypot(as_one, of_left) : of_left;
    }
    if (parameter >= kImuScale) {
        return ImuScale::is_diagonal(parameter - kImuScale) ? imu_scale_sigma : imu_misalignment_sigma_rad;
    }
    return estimate_cameras ? single_camera_sigma(parameter) : kUnwantedSigma;
}

double CalibrationConfig::single_camera_sigma(int parameter) const {
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

double CalibrationConfig::walk_per_sqrt_s(int parameter) const {
    if (parameter == kTimeOffset) {
        return estimate_time_offset ? kTimeOffsetWalk_s_per_sqrt_s : 0.0;
    }
    return sigma(parameter) / std::sqrt(kWanderTime_s);
}

Status CalibrationConfig::validate() const { return validate_fields(kCalibrationFields, *this); }

}  // namespace facet
