// SPDX-License-Identifier: BSD-2-Clause
// What the smoother hands to the front-end of the cameras' calibration.
#pragma once

#include <Eigen/Core>
#include <array>

#include "estimator/geometry/lens_correction.h"
#include "estimator/geometry/se3.h"

namespace facet {

/// Corrections of single cameras against the rig as given, and how uncertain they are.
struct CameraCorrections {
    /// Order of the parameters: the left lens, the right camera's pose [theta p], its lens.
    static constexpr int kDim = 6 + 2 * kLensDim;
    using Covariance = Eigen::Matrix<double, kDim, kDim>;

    /// Of the right camera against the left one: the rotation turns on the right of the given T_B_C1, the position adds
    /// to it (m).
    Se3 right;
    std::array<LensCorrection, 2> lens{LensCorrection::Zero(), LensCorrection::Zero()};  ///< left, right
    Covariance covariance = Covariance::Zero();
};

}  // namespace facet
