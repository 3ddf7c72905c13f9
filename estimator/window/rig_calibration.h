// SPDX-License-Identifier: BSD-2-Clause
// What the window may correct of the rig's calibration: the cameras' clock, their pose on the body, each lens, and the
// axes of the IMU.
#pragma once

#include <Eigen/Core>
#include <array>

#include "estimator/factors/stereo_factor.h"
#include "estimator/geometry/lens_correction.h"
#include "estimator/geometry/se3.h"
#include "estimator/imu/preintegration.h"

namespace facet {

/// Offsets in the calibration's tangent vector. First what moves both cameras as one [time_offset theta p], ...
inline constexpr int kTimeOffset = 0;
inline constexpr int kRigTheta = 1;
inline constexpr int kRigPos = 4;
inline constexpr int kRigDim = 7;
/// ... then the parameters of single cameras, in the order of CameraTerms: the left lens, the right camera's pose
/// against the left one [theta p], and its lens.
inline constexpr int kLeftLens = kRigDim;
inline constexpr int kRightTheta = kLeftLens + kLensDim;
inline constexpr int kRightPos = kRightTheta + 3;
inline constexpr int kRightLens = kRightTheta + kPoseDim;
/// ... and the scale and misalignment of the IMU's axes.
inline constexpr int kImuScale = kRigDim + kCameraTermsDim;
inline constexpr int kCalibrationDim = kImuScale + ImuScale::kDim;

/// Corrections of the calibration as given.
///   t_imu = t_image + time_offset_s,    T_B_C0 = T_B_Bc * T_Bc_C0,    T_B_C1 = T_B_Bc * T_Bc_C1.box_plus(right),
/// lens_correction.h for the lenses, and imu_scale.h for the IMU.
struct RigCalibration {
    using Tangent = Eigen::Matrix<double, kCalibrationDim, 1>;

    double time_offset_s = 0.0;
    Se3 T_B_Bc;
    Se3 right;  ///< its rotation turns on the right of the given one, its position adds to the given one
    std::array<LensCorrection, 2> lens{LensCorrection::Zero(), LensCorrection::Zero()};  ///< left, right
    ImuScale imu;

    RigCalibration box_plus(const Tangent& d) const {
        return {time_offset_s + d(kTimeOffset),
                T_B_Bc.box_plus(d.segment<6>(kRigTheta)),
                right.box_plus(d.segment<6>(kRightTheta)),
                {lens[0] + d.segment<kLensDim>(kLeftLens), lens[1] + d.segment<kLensDim>(kRightLens)},
                imu.box_plus(d.segment<ImuScale::kDim>(kImuScale))};
    }
    /// The d with other = box_plus(d).
    Tangent box_minus_to(const RigCalibration& other) const {
        Tangent d;
        d << other.time_offset_s - time_offset_s, T_B_Bc.box_minus_to(other.T_B_Bc), other.lens[0] - lens[0],
            right.box_minus_to(other.right), other.lens[1] - lens[1], imu.box_minus_to(other.imu);
        return d;
    }
    /// Right camera against the frame Bc.
    Se3 T_Bc_C1(const Se3& given) const { return {(given.q * right.q).normalized(), given.p + right.p}; }

    /// How the cameras' poses move with the calibration, expressed as the perturbation [theta p] of the body's pose
    /// that would move them alike: with the body at R_W_B, moving at v_W_B and turning at w_B,
    ///   theta_B = w_B dt + R dtheta,   p_W = v_W dt + R_W_B dp - R_W_B [R dtheta]x p,   (R, p) = T_B_Bc.
    Eigen::Matrix<double, kPoseDim, kRigDim> d_pose(const Eigen::Matrix3d& R_W_B, const Eigen::Vector3d& v_W_B,
                                                    const Eigen::Vector3d& w_B) const {
        const Eigen::Matrix3d R = T_B_Bc.R();
        Eigen::Matrix<double, kPoseDim, kRigDim> d = Eigen::Matrix<double, kPoseDim, kRigDim>::Zero();
        d.block<3, 1>(kTheta, kTimeOffset) = w_B;
        d.block<3, 1>(kPos, kTimeOffset) = v_W_B;
        d.block<3, 3>(kTheta, kRigTheta) = R;
        d.block<3, 3>(kPos, kRigTheta) = R_W_B * skew(T_B_Bc.p) * R;
        d.block<3, 3>(kPos, kRigPos) = R_W_B;
        return d;
    }
};

}  // namespace facet
