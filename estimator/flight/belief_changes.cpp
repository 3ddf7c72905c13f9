// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/belief_changes.h"

#include <algorithm>
#include <cmath>

#include "estimator/factors/rest_factor.h"

namespace facet {
namespace {

// After divergence only the direction of gravity, position and yaw are kept, at least as uncertain as this:
constexpr double kDivergedVelocitySigma = 2.0;  // m/s
constexpr double kDivergedPositionSigma = 1.0;  // m
constexpr double kDivergedYawSigma = 0.2;       // rad
constexpr double kOriginSigma = 1e-4;           // m, rad: a choice, not an estimate
constexpr double kUnknownYawSigma = 1.8;        // rad: that of any direction
// What a vehicle that seems to stand may creep without its IMU noticing (estimator/imu/stationarity.h).
constexpr double kCreep_m_per_s = 0.01;
constexpr double kCreep_rad_per_s = 5e-4;
// What a vehicle may have done, beyond going on as before, in time that nothing was known of.
constexpr double kUnknown_m_per_s = 2.0;
constexpr double kUnknown_rad_per_s = 0.5;

void stand(const Belief& at, Belief& now) {
    now.state.q_W_B = at.state.q_W_B;
    now.state.p_W_B = at.state.p_W_B;
    now.state.v_W_B.setZero();
    now.covariance = at.covariance;
    now.covariance.middleRows<3>(kVel).setZero();
    now.covariance.middleCols<3>(kVel).setZero();
}

}  // namespace

StateCovariance inverse(const StateCovariance& covariance) {
    return covariance.llt().solve(StateCovariance::Identity());
}

void hold_at(const Belief& keyframe, Belief& now) {
    const RestSigmas sigmas;
    stand(keyframe, now);
    now.covariance.diagonal().segment<3>(kTheta).array() += sigmas.theta_rad * sigmas.theta_rad;
    now.covariance.diagonal().segment<3>(kPos).array() += sigmas.p_m * sigmas.p_m;
    now.covariance.diagonal().segment<3>(kVel).setConstant(sigmas.v_m_per_s * sigmas.v_m_per_s);
}

void hold_blind(const Belief& before, double blind_s, Belief& now) {
    const double dt_s = (now.stamp - before.stamp).seconds();
    const RestSigmas sigmas;
    // Sums of steps that are all wrong in the same direction: the deviation grows with time, not with its root.
    const auto growth = [&](double rate) { return rate * rate * dt_s * (2.0 * blind_s - dt_s); };
    stand(before, now);
    StateCovariance& c = now.covariance;
    const double v_variance = sigmas.v_m_per_s * sigmas.v_m_per_s + kCreep_m_per_s * kCreep_m_per_s;
    c.diagonal().segment<3>(kVel).setConstant(v_variance);
    c.diagonal().segment<3>(kPos).array() += growth(kCreep_m_per_s);
    const Eigen::Vector3d up_B = now.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    c.block<3, 3>(kTheta, kTheta) += growth(kCreep_rad_per_s) * up_B * up_B.transpose();
}

void widen_after_unknown(const Eigen::Vector3d& w_B, double lost_s, Belief& belief) {
    const double turned_rad = (std::abs((belief.state.q_W_B * w_B).z()) + kUnknown_rad_per_s) * lost_s;
    const double flown_m = (belief.state.v_W_B.norm() + kUnknown_m_per_s) * lost_s;
    belief.covariance.diagonal().segment<3>(kTheta).array() += turned_rad * turned_rad;
    belief.covariance.diagonal().segment<3>(kPos).array() += flown_m * flown_m;
}

void widen_biases(double gyro_rad_per_s, double accel_m_per_s2, Belief& belief) {
    belief.covariance.diagonal().segment<3>(kBiasGyro).array() += std::pow(gyro_rad_per_s, 2);
    belief.covariance.diagonal().segment<3>(kBiasAccel).array() += std::pow(accel_m_per_s2, 2);
}

void fuse_biases(const Belief& earlier, Belief& now) {
    Eigen::Matrix<double, 6, 1> difference;
    difference << earlier.state.bias.gyro - now.state.bias.gyro, earlier.state.bias.accel - now.state.bias.accel;
    const Eigen::Matrix<double, kStateDim, 6> shared = now.covariance.rightCols<6>();
    const Eigen::Matrix<double, 6, 6> innovation =
        now.covariance.bottomRightCorner<6, 6>() + earlier.covariance.bottomRightCorner<6, 6>();
    const Eigen::Matrix<double, kStateDim, 6> gain = innovation.llt().solve(shared.transpose()).transpose();
    now.state = now.state.box_plus(gain * difference);
    now.covariance = (now.covariance - gain * shared.transpose()).eval();
    now.covariance = (0.5 * (now.covariance + now.covariance.transpose())).eval();
}

void keep_biases(const Belief& before, Belief& now) {
    now.state.bias = before.state.bias;
    now.covariance.rightCols<6>().setZero();
    now.covariance.bottomRows<6>().setZero();
    now.covariance.bottomRightCorner<6, 6>() = before.covariance.bottomRightCorner<6, 6>();
}

void keep_place(const Belief* before, Belief& now) {
    const auto yaw_variance = [](const Belief& b) {
        const Eigen::Matrix3d R = b.state.q_W_B.toRotationMatrix();
        return (R * b.covariance.block<3, 3>(kTheta, kTheta) * R.transpose())(2, 2);
    };
    if (before != nullptr) {
        turn_to_yaw_of(before->state.q_W_B, now);
    }
    StateCovariance& c = now.covariance;
    const Eigen::Matrix3d R_W_B = now.state.q_W_B.toRotationMatrix();
    Eigen::Matrix3d theta_W = R_W_B * c.block<3, 3>(kTheta, kTheta) * R_W_B.transpose();
    theta_W.row(2).setZero();
    theta_W.col(2).setZero();
    theta_W(2, 2) = before != nullptr ? std::min(yaw_variance(*before), kUnknownYawSigma * kUnknownYawSigma)
                                      : kOriginSigma * kOriginSigma;
    c.block<3, 3>(kTheta, kTheta) = R_W_B.transpose() * theta_W * R_W_B;
    c.middleRows<3>(kPos).setZero();
    c.middleCols<3>(kPos).setZero();
    c.block<3, 3>(kPos, kPos) = kOriginSigma * kOriginSigma * Eigen::Matrix3d::Identity();
    if (before != nullptr) {
        now.state.p_W_B = before->state.p_W_B;
        c.block<3, 3>(kPos, kPos) += before->covariance.block<3, 3>(kPos, kPos);
    }
}

void fix_place(Belief& now) {
    StateCovariance& c = now.covariance;
    const Eigen::Matrix3d R_W_B = now.state.q_W_B.toRotationMatrix();
    // Yaw turns with the body: its share of the other parameters' covariance goes with it.
    const StateCovariance before = c;
    Eigen::Matrix3d level = R_W_B.transpose() * Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal() * R_W_B;
    c.middleRows<3>(kTheta) = (level * before.middleRows<3>(kTheta)).eval();
    c.middleCols<3>(kTheta) = (c.middleCols<3>(kTheta) * level.transpose()).eval();
    c.middleRows<3>(kPos).setZero();
    c.middleCols<3>(kPos).setZero();
    const Eigen::Vector3d up_B = R_W_B.transpose() * Eigen::Vector3d::UnitZ();
    c.block<3, 3>(kTheta, kTheta) += kOriginSigma * kOriginSigma * up_B * up_B.transpose();
    c.diagonal().segment<3>(kPos).array() += kOriginSigma * kOriginSigma;
}

Belief salvage(const Belief& trusted, const Belief& now) {
    Belief belief = trusted;
    const double time_s = (now.stamp - trusted.stamp).seconds();
    const double flown_m = (trusted.state.v_W_B.norm() + kDivergedVelocitySigma) * time_s;
    if (!is_finite(belief)) {
        belief = {};
    }
    belief.covariance.diagonal().segment<3>(kPos).array() += flown_m * flown_m;
    if (now.state.q_W_B.coeffs().allFinite()) {
        belief.state.q_W_B = now.state.q_W_B;
        const Eigen::Matrix3d carried = now.covariance.block<3, 3>(kTheta, kTheta);
        belief.covariance.block<3, 3>(kTheta, kTheta) =
            carried.allFinite() ? carried
                                : Eigen::Matrix3d(std::pow(kUnknownYawSigma, 2) * Eigen::Matrix3d::Identity());
    }
    return belief;
}

void fall_back(const NavState& levelled, const Belief& kept, double gyro_rad_per_s, double accel_m_per_s2,
               Belief& now) {
    const Eigen::Vector3d up_B = levelled.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond::FromTwoVectors(kept.state.q_W_B * up_B, Eigen::Vector3d::UnitZ());
    now.state = levelled;
    now.state.q_W_B = (turn * kept.state.q_W_B).normalized();
    now.state.p_W_B = kept.state.p_W_B;
    const Eigen::Matrix3d R = now.state.q_W_B.toRotationMatrix();
    const Eigen::Matrix3d kept_R = kept.state.q_W_B.toRotationMatrix();
    const double yaw_variance = (kept_R * kept.covariance.block<3, 3>(kTheta, kTheta) * kept_R.transpose())(2, 2) +
                                kDivergedYawSigma * kDivergedYawSigma;
    const Eigen::Vector3d theta_W(kWorthlessTiltSigma_rad, kWorthlessTiltSigma_rad,
                                  std::min(std::sqrt(yaw_variance), kUnknownYawSigma));
    StateCovariance& c = now.covariance;
    c.setZero();
    c.block<3, 3>(kTheta, kTheta) = R.transpose() * theta_W.cwiseAbs2().asDiagonal() * R;
    c.block<3, 3>(kPos, kPos) = kept.covariance.block<3, 3>(kPos, kPos);
    c.diagonal().segment<3>(kPos).array() += std::pow(kDivergedPositionSigma, 2);
    c.diagonal().segment<3>(kVel).setConstant(std::pow(kDivergedVelocitySigma, 2));
    c.diagonal().segment<3>(kBiasGyro).setConstant(std::pow(gyro_rad_per_s, 2));
    c.diagonal().segment<3>(kBiasAccel).setConstant(std::pow(accel_m_per_s2, 2));
}

}  // namespace facet
