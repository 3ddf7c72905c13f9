// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/propagation.h"

namespace facet {

StateCovariance propagate_covariance(const NavState& state_i, const StateCovariance& covariance_i,
                                     const Preintegration& preintegration, const ImuNoise& noise) {
    const double dt = preintegration.dt_s();
    Eigen::Quaterniond dq;
    Eigen::Vector3d dp;
    Eigen::Vector3d dv;
    preintegration.corrected(state_i.bias, dq, dp, dv);
    const Eigen::Matrix3d R = state_i.q_W_B.toRotationMatrix();
    const auto& d_delta_d_bias = preintegration.d_delta_d_bias();

    StateCovariance f = StateCovariance::Identity();
    f.block<3, 3>(kTheta, kTheta) = dq.toRotationMatrix().transpose();
    f.block<3, 6>(kTheta, kBiasGyro) = d_delta_d_bias.middleRows<3>(kTheta);
    f.block<3, 3>(kPos, kTheta) = -R * skew(dp);
    f.block<3, 3>(kPos, kVel) = dt * Eigen::Matrix3d::Identity();
    f.block<3, 6>(kPos, kBiasGyro) = R * d_delta_d_bias.middleRows<3>(kPos);
    f.block<3, 3>(kVel, kTheta) = -R * skew(dv);
    f.block<3, 6>(kVel, kBiasGyro) = R * d_delta_d_bias.middleRows<3>(kVel);

    // Noise of dp and dv is in the body frame at i; that of the rotation is on the right of dR already.
    Eigen::Matrix<double, 9, 9> turn = Eigen::Matrix<double, 9, 9>::Identity();
    turn.block<3, 3>(kPos, kPos) = R;
    turn.block<3, 3>(kVel, kVel) = R;
    StateCovariance covariance_j = f * covariance_i * f.transpose();
    covariance_j.topLeftCorner<9, 9>() += turn * preintegration.covariance() * turn.transpose();
    const double gyro_walk = noise.gyro_walk_rad_per_s2_per_sqrt_hz;
    const double accel_walk = noise.accel_walk_m_per_s3_per_sqrt_hz;
    covariance_j.diagonal().segment<3>(kBiasGyro).array() += gyro_walk * gyro_walk * dt;
    covariance_j.diagonal().segment<3>(kBiasAccel).array() += accel_walk * accel_walk * dt;
    return covariance_j;
}

}  // namespace facet
