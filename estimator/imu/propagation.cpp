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
    StateCovariance turn = StateCovariance::Identity();
    turn.block<3, 3>(kPos, kPos) = R;
    turn.block<3, 3>(kVel, kVel) = R;
    StateCovariance added = preintegration.walk_covariance(noise);
    added.topLeftCorner<9, 9>() += preintegration.covariance();
    return f * covariance_i * f.transpose() + turn * added * turn.transpose();
}

}  // namespace facet
