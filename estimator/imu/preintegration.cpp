// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/preintegration.h"

namespace facet {
namespace {

// Offsets in the noise and bias columns.
constexpr int kGyro = 0;
constexpr int kAccel = 3;

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Matrix96 = Eigen::Matrix<double, 9, 6>;

}  // namespace

NavState NavState::box_plus(const Eigen::Matrix<double, 15, 1>& d) const {
    NavState out;
    out.q_W_B = (q_W_B * so3_exp(d.segment<3>(kTheta))).normalized();
    out.p_W_B = p_W_B + d.segment<3>(kPos);
    out.v_W_B = v_W_B + d.segment<3>(kVel);
    out.bias.gyro = bias.gyro + d.segment<3>(kBiasGyro);
    out.bias.accel = bias.accel + d.segment<3>(kBiasAccel);
    return out;
}

Eigen::Matrix<double, 15, 1> NavState::box_minus_to(const NavState& other) const {
    Eigen::Matrix<double, 15, 1> d;
    d.segment<3>(kTheta) = so3_log(q_W_B.conjugate() * other.q_W_B);
    d.segment<3>(kPos) = other.p_W_B - p_W_B;
    d.segment<3>(kVel) = other.v_W_B - v_W_B;
    d.segment<3>(kBiasGyro) = other.bias.gyro - bias.gyro;
    d.segment<3>(kBiasAccel) = other.bias.accel - bias.accel;
    return d;
}

void Preintegration::reset(const ImuBias& bias_linearised) { *this = Preintegration(bias_linearised); }

// One step of length h with the mean rate w and mean specific force a of its two samples (bias taken off):
//   dR+ = dR Exp(w h),  Rm = dR Exp(w h / 2),  dv+ = dv + Rm a h,  dp+ = dp + dv h + 1/2 Rm a h^2.
// Its exact first-order error model, x = [theta p v] with theta on the right of dR, n = noise added to (w, a):
//   x+ = A x + B n,  and the bias enters as n = -b.
Status Preintegration::integrate(const ImuSample& a, const ImuSample& b, const ImuNoise& noise) {
    if (!(b.stamp > a.stamp)) {
        return Status::kOutOfOrder;
    }
    const double h = (b.stamp - a.stamp).seconds();
    const Eigen::Vector3d w = 0.5 * (a.w_B + b.w_B) - bias_.gyro;
    const Eigen::Vector3d f = 0.5 * (a.a_B + b.a_B) - bias_.accel;

    const Eigen::Vector3d half_turn = 0.5 * h * w;
    const Eigen::Quaterniond q_half = so3_exp(half_turn);
    const Eigen::Matrix3d half = q_half.toRotationMatrix();
    const Eigen::Matrix3d mid = (dq_ * q_half).toRotationMatrix();
    const Eigen::Matrix3d d_force_d_theta_mid = -mid * skew(f);
    const Eigen::Matrix3d d_force_d_theta = d_force_d_theta_mid * half.transpose();
    const Eigen::Matrix3d d_force_d_w = d_force_d_theta_mid * so3_right_jacobian(half_turn) * (0.5 * h);

    Matrix9 A = Matrix9::Identity();
    A.block<3, 3>(kTheta, kTheta) = (half * half).transpose();
    A.block<3, 3>(kPos, kTheta) = 0.5 * h * h * d_force_d_theta;
    A.block<3, 3>(kPos, kVel) = h * Eigen::Matrix3d::Identity();
    A.block<3, 3>(kVel, kTheta) = h * d_force_d_theta;

    Matrix96 B = Matrix96::Zero();
    B.block<3, 3>(kTheta, kGyro) = h * so3_right_jacobian(2.0 * half_turn);
    B.block<3, 3>(kPos, kGyro) = 0.5 * h * h * d_force_d_w;
    B.block<3, 3>(kVel, kGyro) = h * d_force_d_w;
    B.block<3, 3>(kPos, kAccel) = 0.5 * h * h * mid;
    B.block<3, 3>(kVel, kAccel) = h * mid;

    // Discrete variance sigma^2 / h. The step's mean noise alone would leave dp and dv fully correlated; white noise in
    // continuous time has variance h^3 / 3 in position, of which B gives h^3 / 4: the rest, h^3 / 12, keeps the
    // covariance positive definite from the first step on.
    const double gyro_variance = noise.gyro_noise_rad_per_s_per_sqrt_hz * noise.gyro_noise_rad_per_s_per_sqrt_hz / h;
    const double accel_density = noise.accel_noise_m_per_s2_per_sqrt_hz * noise.accel_noise_m_per_s2_per_sqrt_hz;
    Eigen::Matrix<double, 6, 1> variance;
    variance << Eigen::Vector3d::Constant(gyro_variance), Eigen::Vector3d::Constant(accel_density / h);

    covariance_ = (A * covariance_ * A.transpose() + B * variance.asDiagonal() * B.transpose()).eval();
    covariance_.diagonal().segment<3>(kPos).array() += accel_density * h * h * h / 12.0;
    covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
    d_delta_d_bias_ = (A * d_delta_d_bias_ - B).eval();

    const Eigen::Vector3d force = mid * f;
    dp_ += h * dv_ + 0.5 * h * h * force;
    dv_ += h * force;
    dq_ = (dq_ * so3_exp(2.0 * half_turn)).normalized();
    dt_s_ += h;
    return Status::kOk;
}

void Preintegration::corrected(const ImuBias& bias, Eigen::Quaterniond& dq, Eigen::Vector3d& dp,
                               Eigen::Vector3d& dv) const {
    Eigen::Matrix<double, 6, 1> d_bias;
    d_bias << bias.gyro - bias_.gyro, bias.accel - bias_.accel;
    const Eigen::Matrix<double, 9, 1> d = d_delta_d_bias_ * d_bias;
    dq = (dq_ * so3_exp(d.segment<3>(kTheta))).normalized();
    dp = dp_ + d.segment<3>(kPos);
    dv = dv_ + d.segment<3>(kVel);
}

NavState Preintegration::predict(const NavState& state_i) const {
    Eigen::Quaterniond dq;
    Eigen::Vector3d dp;
    Eigen::Vector3d dv;
    corrected(state_i.bias, dq, dp, dv);
    NavState state_j = state_i;
    state_j.q_W_B = (state_i.q_W_B * dq).normalized();
    state_j.p_W_B += dt_s_ * state_i.v_W_B + 0.5 * dt_s_ * dt_s_ * kGravity_W + state_i.q_W_B * dp;
    state_j.v_W_B += dt_s_ * kGravity_W + state_i.q_W_B * dv;
    return state_j;
}

}  // namespace facet
