// SPDX-License-Identifier: BSD-2-Clause
// Corrections of the rig's calibration by the window: the cameras' clock and their pose on the body.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/se3.h"
#include "estimator/imu/preintegration.h"

namespace facet {

/// Offsets in the calibration's tangent vector [time_offset theta p].
inline constexpr int kTimeOffset = 0;
inline constexpr int kRigTheta = 1;
inline constexpr int kRigPos = 4;
inline constexpr int kCalibrationDim = 7;

/// Corrections of the calibration, the same for both cameras: the stereo pair itself is not corrected.
///   t_imu = t_image + time_offset_s,    T_B_Ck = T_B_Bc * T_Bc_Ck, the latter as calibrated.
struct RigCalibration {
    using Tangent = Eigen::Matrix<double, kCalibrationDim, 1>;

    double time_offset_s = 0.0;
    Se3 T_B_Bc;

    RigCalibration box_plus(const Tangent& d) const {
        return {time_offset_s + d(kTimeOffset), T_B_Bc.box_plus(d.tail<6>())};
    }
    /// The d with other = box_plus(d).
    Tangent box_minus_to(const RigCalibration& other) const {
        Tangent d;
        d << other.time_offset_s - time_offset_s, T_B_Bc.box_minus_to(other.T_B_Bc);
        return d;
    }

    /// How the cameras' poses move with the calibration, expressed as the perturbation [theta p] of the body's pose
    /// that would move them alike: with the body at R_W_B, moving at v_W_B and turning at w_B,
    ///   theta_B = w_B dt + R dtheta,   p_W = v_W dt + R_W_B dp - R_W_B [R dtheta]x p,   (R, p) = T_B_Bc.
    Eigen::Matrix<double, kPoseDim, kCalibrationDim> d_pose(const Eigen::Matrix3d& R_W_B, const Eigen::Vector3d& v_W_B,
                                                            const Eigen::Vector3d& w_B) const {
        const Eigen::Matrix3d R = T_B_Bc.R();
        Eigen::Matrix<double, kPoseDim, kCalibrationDim> d = Eigen::Matrix<double, kPoseDim, kCalibrationDim>::Zero();
        d.block<3, 1>(kTheta, kTimeOffset) = w_B;
        d.block<3, 1>(kPos, kTimeOffset) = v_W_B;
        d.block<3, 3>(kTheta, kRigTheta) = R;
        d.block<3, 3>(kPos, kRigTheta) = R_W_B * skew(T_B_Bc.p) * R;
        d.block<3, 3>(kPos, kRigPos) = R_W_B;
        return d;
    }
};

}  // namespace facet
