// SPDX-License-Identifier: BSD-2-Clause
// A point on a surface that one keyframe's stereo pair has measured.
#pragma once

#include <Eigen/Core>

namespace facet {

struct DepthPoint {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< (m)
    double sigma_m = 0.0;                           ///< standard deviation along the ray from the left camera
};

}  // namespace facet
