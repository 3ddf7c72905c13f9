// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/geometry/lens_correction.h"

#include <Eigen/LU>
#include <cmath>

namespace facet {
namespace {

/// dD/dk1 and dD/dk2.
Eigen::Matrix2d d_distorted_d_coefficients(Distortion distortion, const Eigen::Vector2d& xy) {
    Eigen::Matrix2d d = Eigen::Matrix2d::Zero();
    const double r2 = xy.squaredNorm();
    if (distortion == Distortion::kRadialTangential) {
        d << r2 * xy, r2 * r2 * xy;
    } else if (distortion == Distortion::kEquidistant && r2 > 0.0) {
        const double r = std::sqrt(r2);
        const double theta = std::atan(r);
        const double t3 = theta * theta * theta;
        d << (t3 / r) * xy, (t3 * theta * theta / r) * xy;
    }
    return d;
}

}  // namespace

LensJacobian d_xy_d_lens(const CameraModel& camera, const Eigen::Vector2d& xy) {
    const CameraIntrinsics& k = camera.intrinsics();
    Eigen::Matrix2d d_distorted_d_xy;
    const Eigen::Vector2d distorted = camera.distort(xy, &d_distorted_d_xy);
    LensJacobian d = LensJacobian::Zero();
    d(0, 0) = -distorted.x();
    d(1, 1) = -distorted.y();
    d(0, 2) = -1.0 / k.fx;
    d(1, 3) = -1.0 / k.fy;
    d.rightCols<2>() = -d_distorted_d_coefficients(k.distortion, xy);
    return d_distorted_d_xy.inverse() * d;
}

}  // namespace facet
