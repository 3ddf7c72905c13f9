// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/stereo_factor.h"

#include <Eigen/Geometry>
#include <cmath>

namespace facet {
namespace {

/// One camera of the pair.
struct Camera {
    const RelativeView& view;
    const RelativeView& view_lin;
    const Eigen::Vector2d& measured;
    Eigen::Matrix2d whitening;
};

/// Both rows of one camera, u and v: arithmetic on them fills a vector register.
using Rows = Eigen::Vector2d;

/// (x, y, z) d for both rows.
Rows combine(double x, double y, double z, const std::array<Rows, 3>& d) { return (x * d[0] + y * d[1]) + z * d[2]; }

/// Puts them into two columns of a transposed Jacobian, from row `first` and column `row` on.
template <class Matrix>
void put_columns(const std::array<Rows, 3>& d, int first, int row, Matrix& to) {
    for (int k = 0; k < 3; ++k) {
        const Rows& both = d[static_cast<std::size_t>(k)];
        to(first + k, row) = both.x();
        to(first + k, row + 1) = both.y();
    }
}

/// d x q for both rows.
std::array<Rows, 3> cross(const std::array<Rows, 3>& d, const Eigen::Vector3d& q) {
    return {q.z() * d[1] - q.y() * d[2], q.x() * d[2] - q.z() * d[0], q.y() * d[0] - q.x() * d[1]};
}

/// M^T d for both rows.
std::array<Rows, 3> transposed_times(const Eigen::Matrix3d& m, const std::array<Rows, 3>& d) {
    return {combine(m(0, 0), m(1, 0), m(2, 0), d), combine(m(0, 1), m(1, 1), m(2, 1), d),
            combine(m(0, 2), m(1, 2), m(2, 2), d)};
}

/// Fills two rows of residual and Jacobian by the point, starting at `row`.
/// @return kDegenerate if the point is behind the camera
Status linearize(const Camera& camera, const InverseDepthPoint& point, const RobustLoss& loss, int row,
                 StereoResidual& out) {
    ImageRows& rows = out.rows[static_cast<std::size_t>(row / 2)];
    const Eigen::Vector3d q = camera.view.sight_line(point);
    rows.q_lin = camera.view_lin.sight_line(point);
    if (!is_in_front(q) || !is_in_front(rows.q_lin)) {
        return Status::kDegenerate;
    }
    const Eigen::Vector2d r = camera.whitening * (q.head<2>() / q.z() - camera.measured);
    const double s = r.squaredNorm();
    out.squared_errors(row / 2) = s;
    const double weight = loss.weight(s);
    out.weights(row / 2) = weight;
    const double sqrt_weight = std::sqrt(weight);
    out.loss += {1, s, weight, loss.slope(s), weight * weight * s};
    out.r.segment<2>(row) = sqrt_weight * r;

    const Eigen::Matrix2d weighted = sqrt_weight * camera.whitening;
    rows.minus_d_r_d_measured_t = weighted.transpose();
    const double inv_z = 1.0 / rows.q_lin.z();
    const Eigen::Vector2d xy = rows.q_lin.head<2>() * inv_z;
    std::array<Rows, 3>& d = rows.d_r_d_q;
    d[0] = inv_z * weighted.col(0);
    d[1] = inv_z * weighted.col(1);
    d[2] = -xy.x() * d[0] - xy.y() * d[1];
    const auto& T = camera.view_lin.T_C_H;
    out.d_r_d_point.block<2, 1>(row, 0) = combine(T(0, 0), T(1, 0), T(2, 0), d);
    out.d_r_d_point.block<2, 1>(row, 1) = combine(T(0, 1), T(1, 1), T(2, 1), d);
    out.d_r_d_point.block<2, 1>(row, 2) = combine(T(0, 3), T(1, 3), T(2, 3), d);
    return Status::kOk;
}

/// The sight line in the body's frame, as seen from the body.
Eigen::Vector3d in_body(const Eigen::Vector3d& q, const Eigen::Matrix3d& R_C_B, const Eigen::Vector3d& p_B_C,
                        double rho) {
    return R_C_B.transpose() * q + rho * p_B_C;
}

/// Two rows by the pose. In B: Exp(-theta) q = q + q x theta, and a move of the body by dp takes rho dp from q.
void add_pose(const ImageRows& rows, const Eigen::Matrix3d& R_C_B, const Eigen::Vector3d& p_B_C,
              const Eigen::Matrix3d& R_B_W_lin, double rho, int row, StereoLinearization& out) {
    const Eigen::Vector3d q_B = in_body(rows.q_lin, R_C_B, p_B_C, rho);
    const std::array<Rows, 3> d_r_d_q_B = transposed_times(R_C_B, rows.d_r_d_q);
    const Eigen::Matrix3d d_q_B_d_p = -rho * R_B_W_lin;
    put_columns(cross(d_r_d_q_B, q_B), 0, row, out.d_r_d_T_W_B_transposed);
    put_columns(transposed_times(d_q_B_d_p, d_r_d_q_B), 3, row, out.d_r_d_T_W_B_transposed);
    out.d_r_d_T_W_B_transposed.block<2, 2>(6, row).setZero();
}

/// The rows of the left image by its lens.
void add_left_lens(const ImageRows& rows, const LensJacobian& lens, StereoLinearization& out) {
    out.d_r_d_left_lens_transposed.noalias() =
        -lens.transpose().cast<double>().lazyProduct(rows.minus_d_r_d_measured_t);
}

/// The rows of the right image by its camera's pose on the pair and its lens.
void add_right_camera(const ImageRows& rows, const CameraTerms& terms, double rho, StereoLinearization& out) {
    auto& d = out.d_r_d_right_camera_transposed;
    // In C: Exp(-theta) q = q + q x theta, and a move of the camera by dp takes rho dp from q.
    put_columns(cross(rows.d_r_d_q, rows.q_lin), 0, 0, d);
    for (int i = 0; i < 2; ++i) {
        const Eigen::Vector3d d_r_d_q(rows.d_r_d_q[0](i), rows.d_r_d_q[1](i), rows.d_r_d_q[2](i));
        d.col(i).segment<3>(3) = -rho * (terms.R_Bc_C1 * d_r_d_q);
    }
    d.middleRows<kLensDim>(kPoseDim).noalias() =
        -terms.right.transpose().cast<double>().lazyProduct(rows.minus_d_r_d_measured_t);
    d.bottomRows<2>().setZero();
}

/// The part of a gradient that belongs to the lens.
Eigen::Matrix<double, kLensDim, 1> lens_gradient(const ImageRows& rows, const LensJacobian& lens,
                                                 const Eigen::Vector2d& r) {
    return -lens.transpose().cast<double>().lazyProduct((rows.minus_d_r_d_measured_t * r).eval());
}

/// d^T r: by the sight line.
Eigen::Vector3d sight_gradient(const ImageRows& rows, const Eigen::Vector2d& r) {
    return {rows.d_r_d_q[0].dot(r), rows.d_r_d_q[1].dot(r), rows.d_r_d_q[2].dot(r)};
}

}  // namespace

Status linearize_point(const StereoMeasurement& z, const StereoGeometry& geometry, const StereoView& view,
                       const StereoView& view_lin, const InverseDepthPoint& point, const RobustLoss& loss,
                       StereoResidual& out) {
    out.has_right = z.has_right;
    out.loss = {};
    const Camera left{view.left, view_lin.left, z.left_xy, geometry.scale * z.d_left_d_xy.cast<double>()};
    FACET_TRY(linearize(left, point, loss, 0, out));
    if (!z.has_right) {
        out.r.tail<2>().setZero();
        out.d_r_d_point.bottomRows<2>().setZero();
        return Status::kOk;
    }
    const Camera right{view.right, view_lin.right, z.right_xy, geometry.scale * z.d_right_d_xy.cast<double>()};
    return linearize(right, point, loss, 2, out);
}

Status linearize_stereo(const StereoMeasurement& z, const StereoGeometry& geometry, const StereoView& view,
                        const StereoView& view_lin, const Eigen::Matrix3d& R_B_W_lin, const InverseDepthPoint& point,
                        const RobustLoss& loss, const CameraTerms* cameras, StereoLinearization& out) {
    out.has_cameras = cameras != nullptr;
    FACET_TRY(linearize_point(z, geometry, view, view_lin, point, loss, out));
    add_pose(out.rows[0], geometry.R_C0_B, geometry.p_B_C0, R_B_W_lin, point.rho, 0, out);
    if (out.has_cameras) {
        add_left_lens(out.rows[0], cameras->left, out);
    }
    if (!z.has_right) {
        out.d_r_d_T_W_B_transposed.rightCols<2>().setZero();
        return Status::kOk;
    }
    add_pose(out.rows[1], geometry.R_C1_B, geometry.p_B_C1, R_B_W_lin, point.rho, 2, out);
    if (out.has_cameras) {
        add_right_camera(out.rows[1], *cameras, point.rho, out);
    }
    return Status::kOk;
}

StereoGradient stereo_gradient(const StereoResidual& at, const Eigen::Vector4d& r, const StereoGeometry& geometry,
                               const Eigen::Matrix3d& R_B_W_lin, double rho, const CameraTerms* cameras) {
    StereoGradient out;
    const ImageRows& left = at.rows[0];
    const Eigen::Vector2d left_r = r.head<2>();
    Eigen::Vector3d by_q_B = geometry.R_C0_B.transpose() * sight_gradient(left, left_r);
    out.pose.head<3>() = by_q_B.cross(in_body(left.q_lin, geometry.R_C0_B, geometry.p_B_C0, rho));
    if (cameras != nullptr) {
        out.left_lens = lens_gradient(left, cameras->left, left_r);
    }
    if (at.has_right) {
        const ImageRows& right = at.rows[1];
        const Eigen::Vector2d right_r = r.tail<2>();
        const Eigen::Vector3d by_q = sight_gradient(right, right_r);
        const Eigen::Vector3d by_right_q_B = geometry.R_C1_B.transpose() * by_q;
        out.pose.head<3>() += by_right_q_B.cross(in_body(right.q_lin, geometry.R_C1_B, geometry.p_B_C1, rho));
        by_q_B += by_right_q_B;
        if (cameras != nullptr) {
            out.right_camera.head<3>() = by_q.cross(right.q_lin);
            out.right_camera.segment<3>(3) = -rho * (cameras->R_Bc_C1 * by_q);
            out.right_camera.tail<kLensDim>() = lens_gradient(right, cameras->right, right_r);
        }
    }
    out.pose.tail<3>() = -rho * (R_B_W_lin.transpose() * by_q_B);
    return out;
}

}  // namespace facet
