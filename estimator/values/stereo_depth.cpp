// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/values/stereo_depth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "estimator/geometry/lens_correction.h"

namespace facet {

CamerasRow d_inverse_depth_d_cameras(const Eigen::Vector3d& p_C0, const StereoRig& rig) {
    const Se3 T_C1_C0 = rig.T_C1_C0();
    const double rho = 1.0 / p_C0.z();
    const Eigen::Vector3d x = rho * p_C0;
    const Eigen::Vector3d q = T_C1_C0.q * x + rho * T_C1_C0.p;
    Eigen::Matrix<double, 2, 3> d_image_d_q;
    d_image_d_q << 1.0, 0.0, -q.x() / q.z(), 0.0, 1.0, -q.y() / q.z();
    d_image_d_q /= q.z();
    const Eigen::Vector2d line = d_image_d_q * T_C1_C0.p;  // of the image by rho
    const Eigen::RowVector2d d_rho = -line.transpose() / line.squaredNorm();
    const Eigen::RowVector3d d_rho_d_q = d_rho * d_image_d_q;
    const Eigen::Matrix<double, 2, kLensDim> left = d_xy_d_lens(rig.left, x.head<2>()).cast<double>();
    const Eigen::Matrix<double, 2, kLensDim> right = d_xy_d_lens(rig.right, q.head<2>() / q.z()).cast<double>();
    CamerasRow d_rho_d_cameras;
    d_rho_d_cameras << d_rho_d_q * T_C1_C0.q.toRotationMatrix().leftCols<2>() * left, d_rho_d_q.cross(q),
        -rho * d_rho_d_q * rig.T_B_C1.q.toRotationMatrix().transpose(), -d_rho * right;
    return d_rho_d_cameras;
}

double inverse_depth_sigma(double depth_m, const StereoRig& rig, const CameraCorrections& cameras) {
    const Eigen::Vector3d ahead(0.0, 0.0, depth_m);
    constexpr double kNear_m = 0.01;
    if (!rig.has_right || depth_m < kNear_m || (rig.T_C1_C0() * ahead).z() < kNear_m) {
        return 0.0;
    }
    const CamerasRow d = d_inverse_depth_d_cameras(ahead, rig);
    return std::sqrt(std::max(0.0, d.dot(d * cameras.covariance)));
}

}  // namespace facet
