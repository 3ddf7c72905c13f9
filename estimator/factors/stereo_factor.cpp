// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/stereo_factor.h"

#include <cmath>

namespace facet {
namespace {

constexpr double kMinCosine = 0.05;  // least forward part of a sight line, relative to its length

struct Camera {
    const Eigen::Matrix3d& R_C_B;
    const Eigen::Vector3d& p_B_C;
    double scale;
};

/// Direction to the point in the camera (scaled by rho); false if behind.
bool sight_line(const Camera& camera, const Eigen::Vector3d& q_B, double rho, Eigen::Vector3d& q_C) {
    q_C = camera.R_C_B * (q_B - rho * camera.p_B_C);
    return q_C.z() > kMinCosine * q_C.norm();
}

}  // namespace

Status linearize_stereo(const StereoMeasurement& z, const StereoGeometry& geometry, const Se3& T_W_B,
                        const Se3& T_W_B_lin, const CameraPose& host, const InverseDepthPoint& point,
                        const HuberLoss& loss, StereoLinearization& out) {
    const ScaledWorldPoint world(host, point);
    const Eigen::Matrix3d R_B_W = T_W_B.R().transpose();
    const Eigen::Matrix3d R_B_W_lin = T_W_B_lin.R().transpose();
    const Eigen::Vector3d q_B = R_B_W * world.from(T_W_B.p);
    const Eigen::Vector3d q_B_lin = R_B_W_lin * world.from(T_W_B_lin.p);

    Eigen::Matrix<double, 3, 6> d_q_B_d_pose;  // theta: Exp(-theta) q = q + q x theta
    d_q_B_d_pose << skew(q_B_lin), -world.rho * R_B_W_lin;
    Eigen::Matrix3d d_q_B_d_point;
    d_q_B_d_point.leftCols<2>() = (R_B_W_lin * host.R_C_W.transpose()).leftCols<2>();
    d_q_B_d_point.col(2) = R_B_W_lin * (world.centre_W - T_W_B_lin.p);

    const Camera cameras[2] = {{geometry.R_C0_B, geometry.p_B_C0, geometry.scale_left},
                               {geometry.R_C1_B, geometry.p_B_C1, geometry.scale_right}};
    const Eigen::Vector2d measured[2] = {z.left_xy, z.right_xy};
    const int count = z.has_right ? 2 : 1;

    StereoLinearization result;
    result.r.setZero();
    result.d_r_d_T_W_B.setZero();
    result.d_r_d_point.setZero();
    for (int k = 0; k < count; ++k) {
        const Camera& camera = cameras[k];
        Eigen::Vector3d q_C;
        Eigen::Vector3d q_C_lin;
        if (!sight_line(camera, q_B, world.rho, q_C) || !sight_line(camera, q_B_lin, world.rho, q_C_lin)) {
            return Status::kDegenerate;
        }
        const Eigen::Vector2d r = camera.scale * (q_C.head<2>() / q_C.z() - measured[k]);
        const double s = r.squaredNorm();
        const double sqrt_weight = std::sqrt(loss.weight(s));
        result.cost += loss.cost(s);
        result.squared_error += s;

        const double inv_z = 1.0 / q_C_lin.z();
        Eigen::Matrix<double, 2, 3> d_r_d_q_C;
        d_r_d_q_C << inv_z, 0.0, -q_C_lin.x() * inv_z * inv_z, 0.0, inv_z, -q_C_lin.y() * inv_z * inv_z;
        d_r_d_q_C *= sqrt_weight * camera.scale;
        const Eigen::Matrix<double, 2, 3> d_r_d_q_B = d_r_d_q_C * camera.R_C_B;
        result.r.segment<2>(2 * k) = sqrt_weight * r;
        result.d_r_d_T_W_B.middleRows<2>(2 * k).noalias() = d_r_d_q_B * d_q_B_d_pose;
        result.d_r_d_point.middleRows<2>(2 * k).noalias() = d_r_d_q_B * d_q_B_d_point;
        result.d_r_d_point.block<2, 1>(2 * k, 2).noalias() -= d_r_d_q_B * camera.p_B_C;
    }
    out = result;
    return Status::kOk;
}

}  // namespace facet
