// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/stereo_factor.h"

#include <array>
#include <cmath>

namespace facet {
namespace {

/// One camera of the pair.
struct Camera {
    const RelativeView& view;
    const RelativeView& view_lin;
    const Eigen::Matrix3d& R_C_B;
    const Eigen::Vector3d& p_B_C;
    const Eigen::Vector2d& measured;
    Eigen::Matrix2d whitening;
};

/// Both rows of one camera, u and v: arithmetic on them fills a vector register.
using Rows = Eigen::Vector2d;

/// What the rows of one camera are derived by, weights included.
struct ImageRows {
    Eigen::Vector3d q_lin;                   ///< sight line in C where Jacobians are evaluated
    std::array<Rows, 3> d_r_d_q;             ///< by the sight line
    Eigen::Matrix2d minus_d_r_d_measured_t;  ///< by the measured point, times -1, transposed
};

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

/// Fills two rows, starting at `row`. @return kDegenerate if the point is behind the camera
Status linearize(const Camera& camera, const Eigen::Matrix3d& R_B_W_lin, const InverseDepthPoint& point,
                 const RobustLoss& loss, int row, StereoLinearization& out, ImageRows& rows) {
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
    out.cost += loss.cost(s);
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
    // In B: Exp(-theta) q = q + q x theta, and a move of the body by dp takes rho dp from q.
    const Eigen::Vector3d q_B = camera.R_C_B.transpose() * rows.q_lin + point.rho * camera.p_B_C;
    const std::array<Rows, 3> d_r_d_q_B = transposed_times(camera.R_C_B, d);
    const Eigen::Matrix3d d_q_B_d_p = -point.rho * R_B_W_lin;
    put_columns(cross(d_r_d_q_B, q_B), 0, row, out.d_r_d_T_W_B_transposed);
    put_columns(transposed_times(d_q_B_d_p, d_r_d_q_B), 3, row, out.d_r_d_T_W_B_transposed);
    out.d_r_d_T_W_B_transposed.block<2, 2>(6, row).setZero();
    return Status::kOk;
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

}  // namespace

Status linearize_stereo(const StereoMeasurement& z, const StereoGeometry& geometry, const StereoView& view,
                        const StereoView& view_lin, const Eigen::Matrix3d& R_B_W_lin, const InverseDepthPoint& point,
                        const RobustLoss& loss, const CameraTerms* cameras, StereoLinearization& out) {
    out.has_right = z.has_right;
    out.has_cameras = cameras != nullptr;
    out.cost = 0.0;
    out.loss = {};
    ImageRows rows;
    const Camera left{view.left,       view_lin.left, geometry.R_C0_B,
                      geometry.p_B_C0, z.left_xy,     geometry.scale * z.d_left_d_xy.cast<double>()};
    FACET_TRY(linearize(left, R_B_W_lin, point, loss, 0, out, rows));
    if (out.has_cameras) {
        add_left_lens(rows, cameras->left, out);
    }
    if (!z.has_right) {
        out.r.tail<2>().setZero();
        out.d_r_d_point.bottomRows<2>().setZero();
        out.d_r_d_T_W_B_transposed.rightCols<2>().setZero();
        return Status::kOk;
    }
    const Camera right{view.right,      view_lin.right, geometry.R_C1_B,
                       geometry.p_B_C1, z.right_xy,     geometry.scale * z.d_right_d_xy.cast<double>()};
    FACET_TRY(linearize(right, R_B_W_lin, point, loss, 2, out, rows));
    if (out.has_cameras) {
        add_right_camera(rows, *cameras, point.rho, out);
    }
    return Status::kOk;
}

}  // namespace facet
