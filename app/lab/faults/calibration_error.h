// SPDX-License-Identifier: BSD-2-Clause
// Calibrations perturbed by K sigma of a good calibration.
#pragma once

#include <cstdint>

#include "estimator/geometry/stereo_rig.h"

namespace facet {

/// 1 sigma of a good calibration, for each parameter: what Kalibr reports for a careful
/// recording of a target with global-shutter cameras of 60 to 90 degrees.
struct CalibrationSigmas {
    double focal = 5e-4;           ///< of fx and of fy, relative
    double principal_px = 0.3;     ///< of cx and of cy
    double radial = 5e-4;          ///< of k1 and of k2
    double tangential = 1e-4;      ///< of p1 and of p2, radial-tangential model only
    double rotation_rad = 5.2e-4;  ///< of each camera on the body, about every axis: 0.03 degrees
    double place_m = 3e-4;         ///< of each camera on the body, along every axis
};

/// How errors are distributed.
enum class ErrorDraw : std::uint8_t {
    kNormal,
    kTails,  ///< Student's t with three degrees of freedom: each parameter as if its sigma had a factor of its own
};

/// The rig with an error in every parameter of both cameras, each drawn independently: `factor` times its sigma times a
/// number that depends on the seed alone, so that factors of one seed lie on a line. Time offset and IMU stay.
/// @return false if the result is no usable rig (`rig` untouched): the factor is too large. Reentrant.
bool add_calibration_error(double factor, std::uint64_t seed, StereoRig& rig, ErrorDraw draw = ErrorDraw::kNormal,
                           const CalibrationSigmas& sigmas = {});

}  // namespace facet
