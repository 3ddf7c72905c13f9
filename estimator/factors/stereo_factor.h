// SPDX-License-Identifier: BSD-2-Clause
// Reprojection of one landmark into the two cameras of one keyframe.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "estimator/geometry/lens_correction.h"
#include "estimator/geometry/relative_view.h"
#include "estimator/geometry/robust_loss.h"
#include "estimator/values/nav_state.h"
#include "platform/base/status.h"

namespace facet {

/// One landmark as seen by one keyframe: normalised undistorted points, and how the pixel moves with each.
struct StereoMeasurement {
    Eigen::Vector2d left_xy = Eigen::Vector2d::Zero();
    Eigen::Vector2d right_xy = Eigen::Vector2d::Zero();  ///< only if has_right
    bool has_right = false;
    Eigen::Matrix2f d_left_d_xy = Eigen::Matrix2f::Identity();   ///< of the left pixel by left_xy (px)
    Eigen::Matrix2f d_right_d_xy = Eigen::Matrix2f::Identity();  ///< likewise; only if has_right
};

/// Both cameras on the body, in the form projections need, and the weight of their pixels.
struct StereoGeometry {
    Eigen::Matrix3d R_C0_B = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d R_C1_B = Eigen::Matrix3d::Identity();
    Eigen::Vector3d p_B_C0 = Eigen::Vector3d::Zero();
    Eigen::Vector3d p_B_C1 = Eigen::Vector3d::Zero();
    double scale = 1.0;  ///< one over a pixel's sigma: whitens residuals (1/px)
};

/// Parameters of single cameras that a residual depends on: the left lens, then the right camera's pose against the
/// left one [theta p] and its lens.
inline constexpr int kRightCameraDim = kPoseDim + kLensDim;
inline constexpr int kCameraTermsDim = kLensDim + kRightCameraDim;

/// What a residual's dependence on them is made of.
struct CameraTerms {
    const LensJacobian& left;
    const LensJacobian& right;       ///< only if there is a right measurement
    const Eigen::Matrix3d& R_Bc_C1;  ///< of the right camera in the frame in which its position is counted
};

/// How both cameras of one keyframe see a host's chart.
struct StereoView {
    RelativeView left;
    RelativeView right;
};

/// What the rows of one camera are derived by, weights included. The rows u and v side by side fill a vector register.
struct ImageRows {
    Eigen::Vector3d q_lin;                   ///< sight line in C where Jacobians are evaluated
    std::array<Eigen::Vector2d, 3> d_r_d_q;  ///< by the sight line
    Eigen::Matrix2d minus_d_r_d_measured_t;  ///< by the measured point, times -1, transposed
};

/// Whitened, robustly weighted residual of one measurement: rows (u0, v0, u1, v1), the last two zero without a right
/// measurement. The weights are applied already: the normal equations are J^T J and J^T r.
struct StereoResidual {
    Eigen::Vector4d r;
    Eigen::Matrix<double, 4, 3> d_r_d_point;  ///< order [x y rho] of the host chart
    bool has_right = false;
    LossSums loss;                   ///< over the cameras
    Eigen::Vector2d weights;         ///< rho' of either camera, the right one's only if has_right
    Eigen::Vector2d squared_errors;  ///< |r|^2 without weights of either camera, the right one's only if has_right
    std::array<ImageRows, 2> rows;   ///< of either camera, the right one's only if has_right

    /// Squared errors of the cameras that measured.
    std::span<const double> squares() const { return {squared_errors.data(), has_right ? 2U : 1U}; }
};

/// The same with its Jacobians by pose and cameras.
struct StereoLinearization : StereoResidual {
    /// Parameters padded to whole vectors: rows of J^T beyond the parameters are zero.
    static constexpr int kPaddedPoseDim = 8;
    static constexpr int kPaddedRightDim = 16;
    static_assert(kLensDim % 8 == 0, "the left lens needs no padding");

    Eigen::Matrix<double, kPaddedPoseDim, 4> d_r_d_T_W_B_transposed;  ///< order [theta p]
    bool has_cameras = false;  ///< whether the next two are filled, the second one only if has_right
    Eigen::Matrix<double, kLensDim, 2> d_r_d_left_lens_transposed;            ///< of the rows u0, v0
    Eigen::Matrix<double, kPaddedRightDim, 2> d_r_d_right_camera_transposed;  ///< of u1, v1; order [theta p lens]
};

/// J^T r of those Jacobians.
struct StereoGradient {
    Eigen::Matrix<double, kPoseDim, 1> pose;
    Eigen::Matrix<double, kLensDim, 1> left_lens;            ///< only with CameraTerms
    Eigen::Matrix<double, kRightCameraDim, 1> right_camera;  ///< likewise, and only if there is a right measurement
};

/// Reprojection residual of a landmark in both cameras of the keyframe at T_W_B, in pixels to first order.
///   q_Ck = T_Ck_H (x, y, 1, rho) = R_Ck_B (R_W_B^T (ray_W + rho (centre_W - p_W_B)) - rho p_B_Ck)
///   r_k  = scale d_uv_d_xy_k (q_Ck.xy / q_Ck.z - xy_k)
/// The Jacobian of the pixel by the undistorted point makes residuals of all places in the image equally precise: a
/// pixel at the border of a wide lens covers several times the angle, and tens of times the tangent, of one in its
/// middle.
/// Structureless vision factor before elimination of the point: [Forster17] Sec. VII, with an inverse-depth chart.
/// The host camera only defines the chart of the point: there is no Jacobian with respect to the host's pose, because
/// the point is a free variable that is eliminated.
/// @param view      the host as seen from the pose at which the residual is evaluated
/// @param view_lin  likewise from the pose at which the Jacobians are evaluated (first-estimate Jacobians); equal to
///                  `view` if free
/// @param R_B_W_lin rotation of the latter pose
/// @param cameras   for the Jacobian by the parameters of single cameras; nullptr to skip
/// @return kDegenerate if the point is behind a camera at either pose (then `out` is undefined). No heap. Reentrant.
Status linearize_stereo(const StereoMeasurement& z, const StereoGeometry& geometry, const StereoView& view,
                        const StereoView& view_lin, const Eigen::Matrix3d& R_B_W_lin, const InverseDepthPoint& point,
                        const RobustLoss& loss, const CameraTerms* cameras, StereoLinearization& out);

/// The residual and its Jacobian by the point alone, as linearize_stereo().
Status linearize_point(const StereoMeasurement& z, const StereoGeometry& geometry, const StereoView& view,
                       const StereoView& view_lin, const InverseDepthPoint& point, const RobustLoss& loss,
                       StereoResidual& out);

/// J^T r for any r in the place of the residual's own, without the Jacobians J by pose and cameras: less work where
/// no more than the gradient is needed.
/// @param cameras  as for linearize_stereo()
StereoGradient stereo_gradient(const StereoResidual& at, const Eigen::Vector4d& r, const StereoGeometry& geometry,
                               const Eigen::Matrix3d& R_B_W_lin, double rho, const CameraTerms* cameras);

}  // namespace facet
