// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/stereo_factor.h"

#include <cmath>

namespace facet {
namespace {

/// One camera of the pair.
struct Camera {
    const RelativeView& view;
    const RelativeView& view_lin;
    const Eigen::Matrix3d& R_C_B;
    const Eigen::Vector3d& p_B_C;
    double scale;
    const Eigen::Vector2d& measured;
    const LensJacobian* lens;                 ///< nullptr: no Jacobian by parameters of this camera
    const Eigen::Matrix3d* R_Bc_C = nullptr;  ///< nullptr: the camera has no pose of its own
};

constexpr int kFirstLens = 6;  // row of the left lens in the Jacobian by parameters of single cameras

/// Fills two rows, starting at `row`. @return kDegenerate if the point is behind the camera
Status linearize(const Camera& camera, const Eigen::Matrix3d& R_B_W_lin, const InverseDepthPoint& point,
                 const RobustLoss& loss, int row, StereoLinearization& out) {
    const Eigen::Vector3d q = camera.view.sight_line(point);
    const Eigen::Vector3d q_lin = camera.view_lin.sight_line(point);
    if (!is_in_front(q) || !is_in_front(q_lin)) {
        return Status::kDegenerate;
    }
    const Eigen::Vector2d r = camera.scale * (q.head<2>() / q.z() - camera.measured);
    const double s = r.squaredNorm();
    const double weight = loss.weight(s);
    const double sqrt_weight = std::sqrt(weight);
    out.cost += loss.cost(s);
    out.loss += {1, s, weight, loss.slope(s), weight * weight * s};
    out.r.segment<2>(row) = sqrt_weight * r;

    const double gain = sqrt_weight * camera.scale / q_lin.z();
    const Eigen::Vector2d xy = q_lin.head<2>() / q_lin.z();
    out.d_r_d_point.middleRows<2>(row) = gain * camera.view_lin.d_image_d_point_times_z(xy);
    // In B: Exp(-theta) q = q + q x theta, and a move of the body by dp takes rho dp from q.
    const Eigen::Vector3d q_B = camera.R_C_B.transpose() * q_lin + point.rho * camera.p_B_C;
    for (int i = 0; i < 2; ++i) {
        const Eigen::Vector3d d_r_d_q_B = gain * (camera.R_C_B.row(i) - xy(i) * camera.R_C_B.row(2)).transpose();
        auto column = out.d_r_d_T_W_B_transposed.col(row + i);
        column.head<3>() = d_r_d_q_B.cross(q_B);
        column.segment<3>(3) = -point.rho * (R_B_W_lin.transpose() * d_r_d_q_B);
        if (camera.lens == nullptr) {
            continue;
        }
        auto own = out.d_r_d_cameras_transposed.col(row + i);
        own.segment<kLensDim>(kFirstLens + (row / 2) * kLensDim) =
            (-sqrt_weight * camera.scale) * camera.lens->row(i).transpose();
        if (camera.R_Bc_C != nullptr) {
            // In C: Exp(-theta) q = q + q x theta, and a move of the camera by dp takes rho dp from q.
            const Eigen::Vector3d d_r_d_q = gain * Eigen::Vector3d(i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, -xy(i));
            own.head<3>() = d_r_d_q.cross(q_lin);
            own.segment<3>(3) = -point.rho * (*camera.R_Bc_C * d_r_d_q);
        }
    }
    return Status::kOk;
}

}  // namespace

Status linearize_stereo(const StereoMeasurement& z, const StereoGeometry& geometry, const StereoView& view,
                        const StereoView& view_lin, const Eigen::Matrix3d& R_B_W_lin, const InverseDepthPoint& point,
                        const RobustLoss& loss, const CameraTerms* cameras, StereoLinearization& out) {
    StereoLinearization result;
    result.r.setZero();
    result.d_r_d_T_W_B_transposed.setZero();
    result.d_r_d_point.setZero();
    result.has_cameras = cameras != nullptr;
    if (result.has_cameras) {
        result.d_r_d_cameras_transposed.setZero();
    }
    const Camera left{view.left,
                      view_lin.left,
                      geometry.R_C0_B,
                      geometry.p_B_C0,
                      geometry.scale_left,
                      z.left_xy,
                      cameras != nullptr ? &cameras->left : nullptr};
    FACET_TRY(linearize(left, R_B_W_lin, point, loss, 0, result));
    if (z.has_right) {
        const Camera right{view.right,
                           view_lin.right,
                           geometry.R_C1_B,
                           geometry.p_B_C1,
                           geometry.scale_right,
                           z.right_xy,
                           cameras != nullptr ? &cameras->right : nullptr,
                           cameras != nullptr ? &cameras->R_Bc_C1 : nullptr};
        FACET_TRY(linearize(right, R_B_W_lin, point, loss, 2, result));
    }
    out = result;
    return Status::kOk;
}

}  // namespace facet
