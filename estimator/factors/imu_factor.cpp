// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/factors/imu_factor.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace facet {
namespace {

using Vector15 = Eigen::Matrix<double, 15, 1>;
using Matrix15 = Eigen::Matrix<double, 15, 15>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

// Least standard deviations of the preintegrated deltas, added in quadrature. They bound the weight of an interval of
// a few samples, where rounding of stamps and the integration's own error exceed the white noise; over 0.2 s of a
// consumer-grade IMU they add about 1 %.
constexpr double kMinThetaSigmaRad = 1e-6;
constexpr double kMinPosSigmaM = 1e-5;
constexpr double kMinVelSigmaMPerS = 1e-5;

/// root * x with root block diagonal: 9x9 lower triangular, then diagonal. Products of this size are faster by
/// coefficients than by Eigen's blocked kernels.
template <int kColumns>
Eigen::Matrix<double, 15, kColumns> whiten(const Matrix15& root, const Eigen::Matrix<double, 15, kColumns>& x) {
    Eigen::Matrix<double, 15, kColumns> out;
    out.template topRows<9>() = root.topLeftCorner<9, 9>().lazyProduct(x.template topRows<9>());
    out.template bottomRows<6>() = root.diagonal().tail<6>().asDiagonal() * x.template bottomRows<6>();
    return out;
}

/// Unwhitened residual, with the parts its Jacobian needs.
struct RawResidual {
    Vector15 r;
    Eigen::Vector3d d_theta_bias;  ///< correction of dR for bias and scale, Log
    Eigen::Vector3d p_Bi;          ///< R_i^T (p_j - p_i - v_i dt - 1/2 g dt^2)
    Eigen::Vector3d v_Bi;          ///< R_i^T (v_j - v_i - g dt)
};

RawResidual raw_residual(const Preintegration& pre, const NavState& i, const NavState& j, const ImuScale* scale) {
    const double dt = pre.dt_s();
    const Eigen::Vector3d g_W = gravity_W(pre.gravity_m_per_s2());
    Eigen::Quaterniond dq;
    Eigen::Vector3d dp;
    Eigen::Vector3d dv;
    pre.corrected(i.bias, dq, dp, dv, scale);

    RawResidual out;
    const Eigen::Quaterniond q_Bi_W = i.q_W_B.conjugate();
    out.d_theta_bias = pre.d_delta_d_bias().block<3, 3>(kTheta, 0) * (i.bias.gyro - pre.bias().gyro);
    if (scale != nullptr) {
        out.d_theta_bias += pre.d_delta_d_scale().middleRows<3>(kTheta).lazyProduct(pre.scale().box_minus_to(*scale));
    }
    out.p_Bi = q_Bi_W * (j.p_W_B - i.p_W_B - dt * i.v_W_B - 0.5 * dt * dt * g_W);
    out.v_Bi = q_Bi_W * (j.v_W_B - i.v_W_B - dt * g_W);
    out.r.segment<3>(kTheta) = so3_log(dq.conjugate() * q_Bi_W * j.q_W_B);
    out.r.segment<3>(kPos) = out.p_Bi - dp;
    out.r.segment<3>(kVel) = out.v_Bi - dv;
    out.r.segment<3>(kBiasGyro) = j.bias.gyro - i.bias.gyro;
    out.r.segment<3>(kBiasAccel) = j.bias.accel - i.bias.accel;
    return out;
}

/// Unwhitened Jacobian of the residual with respect to state i. [Forster17] app. C, tangent order of this project.
/// The rotation error E = Exp(r_theta) moves as E Exp(-R_j^T R_i dtheta_i) and E Exp(-E^T Jr J_bg dbg).
Matrix15 raw_jacobian_i(const Preintegration& pre, const NavState& i, const NavState& j, const RawResidual& raw) {
    const double dt = pre.dt_s();
    const Eigen::Matrix3d R_Bi_W = i.q_W_B.toRotationMatrix().transpose();
    const Eigen::Vector3d r_theta = raw.r.segment<3>(kTheta);
    const Eigen::Matrix3d inverse_right = so3_right_jacobian_inverse(r_theta);
    const auto& bias_jacobian = pre.d_delta_d_bias();

    Matrix15 d = Matrix15::Zero();
    d.block<3, 3>(kTheta, kTheta) = -inverse_right * (j.q_W_B.conjugate() * i.q_W_B).toRotationMatrix();
    d.block<3, 3>(kTheta, kBiasGyro) = -inverse_right * so3_exp(r_theta).toRotationMatrix().transpose() *
                                       so3_right_jacobian(raw.d_theta_bias) * bias_jacobian.block<3, 3>(kTheta, 0);
    d.block<3, 3>(kPos, kTheta) = skew(raw.p_Bi);
    d.block<3, 3>(kPos, kPos) = -R_Bi_W;
    d.block<3, 3>(kPos, kVel) = -dt * R_Bi_W;
    d.block<3, 6>(kPos, kBiasGyro) = -bias_jacobian.middleRows<3>(kPos);
    d.block<3, 3>(kVel, kTheta) = skew(raw.v_Bi);
    d.block<3, 3>(kVel, kVel) = -R_Bi_W;
    d.block<3, 6>(kVel, kBiasGyro) = -bias_jacobian.middleRows<3>(kVel);
    d.block<6, 6>(kBiasGyro, kBiasGyro) = -Eigen::Matrix<double, 6, 6>::Identity();
    return d;
}

Matrix15 raw_jacobian_j(const NavState& i, const RawResidual& raw) {
    const Eigen::Matrix3d R_Bi_W = i.q_W_B.toRotationMatrix().transpose();
    Matrix15 d = Matrix15::Zero();
    d.block<3, 3>(kTheta, kTheta) = so3_right_jacobian_inverse(raw.r.segment<3>(kTheta));
    d.block<3, 3>(kPos, kPos) = R_Bi_W;
    d.block<3, 3>(kVel, kVel) = R_Bi_W;
    d.block<6, 6>(kBiasGyro, kBiasGyro).setIdentity();
    return d;
}

/// Unwhitened Jacobian of the residual with respect to the scale of the IMU's axes: like that of the bias.
Eigen::Matrix<double, 15, ImuScale::kDim> raw_jacobian_scale(const Preintegration& pre, const RawResidual& raw) {
    const Eigen::Vector3d r_theta = raw.r.segment<3>(kTheta);
    const Eigen::Matrix3d d_theta = -so3_right_jacobian_inverse(r_theta) *
                                    so3_exp(r_theta).toRotationMatrix().transpose() *
                                    so3_right_jacobian(raw.d_theta_bias);
    const auto& d_delta = pre.d_delta_d_scale();
    Eigen::Matrix<double, 15, ImuScale::kDim> d = Eigen::Matrix<double, 15, ImuScale::kDim>::Zero();
    d.middleRows<3>(kTheta) = d_theta.lazyProduct(d_delta.middleRows<3>(kTheta));
    d.middleRows<6>(kPos) = -d_delta.middleRows<6>(kPos);
    return d;
}

}  // namespace

Status ImuFactor::set(const Preintegration& preintegration, const ImuNoise& noise) {
    const double dt = preintegration.dt_s();
    const double gyro_walk = noise.gyro_walk_rad_per_s2_per_sqrt_hz * std::sqrt(dt);
    const double accel_walk = noise.accel_walk_m_per_s3_per_sqrt_hz * std::sqrt(dt);
    if (!(dt > 0.0) || !(gyro_walk > 0.0) || !(accel_walk > 0.0) || !std::isfinite(gyro_walk + accel_walk)) {
        return Status::kDegenerate;
    }
    Matrix9 covariance = preintegration.covariance() + preintegration.walk_covariance(noise).topLeftCorner<9, 9>();
    covariance.diagonal().segment<3>(kTheta).array() += kMinThetaSigmaRad * kMinThetaSigmaRad;
    covariance.diagonal().segment<3>(kPos).array() += kMinPosSigmaM * kMinPosSigmaM;
    covariance.diagonal().segment<3>(kVel).array() += kMinVelSigmaMPerS * kMinVelSigmaMPerS;
    const Eigen::LLT<Matrix9> llt(covariance);
    if (!covariance.allFinite() || llt.info() != Eigen::Success) {
        return Status::kDegenerate;
    }
    // covariance = L L^T, so L^-1 is a square root of its inverse: (L^-1)^T L^-1.
    Matrix9 inverse_root = Matrix9::Identity();
    llt.matrixL().solveInPlace(inverse_root);

    sqrt_information_.setZero();
    sqrt_information_.topLeftCorner<9, 9>() = inverse_root;
    sqrt_information_.diagonal().segment<3>(kBiasGyro).setConstant(1.0 / gyro_walk);
    sqrt_information_.diagonal().segment<3>(kBiasAccel).setConstant(1.0 / accel_walk);
    preintegration_ = preintegration;
    return Status::kOk;
}

Eigen::Matrix<double, 15, 1> ImuFactor::residual(const NavState& i, const NavState& j, const ImuScale* scale) const {
    return whiten(sqrt_information_, raw_residual(preintegration_, i, j, scale).r);
}

void ImuFactor::linearize(const NavState& i, const NavState& j, const NavState& i_lin, const NavState& j_lin,
                          ImuFactorLinearization& out, const ImuScale* scale) const {
    const RawResidual at_lin = raw_residual(preintegration_, i_lin, j_lin, scale);
    out.r = residual(i, j, scale);
    out.d_r_d_i = whiten(sqrt_information_, raw_jacobian_i(preintegration_, i_lin, j_lin, at_lin));
    out.d_r_d_j = whiten(sqrt_information_, raw_jacobian_j(i_lin, at_lin));
    if (preintegration_.differentiates_scale()) {
        out.d_r_d_scale = whiten(sqrt_information_, raw_jacobian_scale(preintegration_, at_lin));
    }
}

}  // namespace facet
