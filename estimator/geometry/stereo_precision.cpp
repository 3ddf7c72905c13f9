// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/geometry/stereo_precision.h"

#include <Eigen/LU>

namespace facet {

Eigen::Matrix3d stereo_covariance(const StereoRig& rig, const Se3& T_C1_C0, const Eigen::Vector3d& p_C0,
                                  double sigma_px) {
    const double weight = 1.0 / (sigma_px * sigma_px);
    Eigen::Matrix3d information = Eigen::Matrix3d::Identity() / p_C0.squaredNorm();
    Eigen::Vector2d uv;
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    if (ok(rig.left.project(p_C0, uv, &d_uv_d_p))) {
        information += weight * d_uv_d_p.transpose() * d_uv_d_p;
    }
    if (ok(rig.right.project(T_C1_C0 * p_C0, uv, &d_uv_d_p))) {
        const Eigen::Matrix<double, 2, 3> d_uv_d_p_C0 = d_uv_d_p * T_C1_C0.R();
        information += weight * d_uv_d_p_C0.transpose() * d_uv_d_p_C0;
    }
    return information.inverse();
}

}  // namespace facet
