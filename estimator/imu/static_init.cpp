// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/static_init.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/imu/stretch.h"
#include "estimator/imu/vibration_share.h"

namespace facet {
namespace {

// The vehicle counts as still at the start only if the mean specific force differs from g by less than this (m/s^2).
constexpr double kStillGravityError_m_per_s2 = 0.7;
// The vehicle counts as still at the start only if the mean rate is below this; more is motion, not bias (rad/s).
constexpr double kStillGyroMean_rad_per_s = 0.2;
// The vehicle counts as still at the start only if the accelerometer's standard deviation is below this (m/s^2).
constexpr double kStillAccelStd_m_per_s2 = 0.3;
// The vehicle counts as still at the start only if the gyroscope's standard deviation is below this (rad/s).
constexpr double kStillGyroStd_rad_per_s = 0.03;
constexpr double kGaugePosSigmaM = 1e-4;
constexpr double kGaugeYawSigmaRad = 1e-4;
constexpr double kMinForceMPerS2 = 1.0;
constexpr double kMinHorizontal = 0.1;  // sine of 5.7 degrees
// If the later half of a stretch differs from the earlier one by more than noise and this, a motion begins.
constexpr double kStillGyroDriftRadPerS = 0.01;
constexpr double kStillAccelDriftMPerS2 = 0.03;
constexpr int kBlocks = 10;
constexpr double kAccelScaleSigma = 0.005;  // as data sheets allow

struct Stretch {
    Timestamp begin;
    Timestamp end;
    double duration_s() const { return (end - begin).seconds(); }
};

/// Force averaged in the body frame at the end of the stretch.
struct TurnedForce {
    Eigen::Vector3d mean_B = Eigen::Vector3d::Zero();
    double direction_spread_rad = 0.0;  ///< rms angle of block means to the mean, per horizontal axis
};

Status find_stretch(const ImuBuffer& buffer, Timestamp stamp, Stretch& out) {
    if (buffer.empty()) {
        return Status::kNotReady;
    }
    Stretch s{std::max(buffer.oldest(), stamp - Duration::from_seconds(InitializerConfig::kMaxDuration_s)), stamp};
    if (s.end < s.begin) {
        return Status::kNotReady;
    }
    FACET_TRY(
        buffer.for_each_step(s.begin, s.end, [&](const ImuSample&, const ImuSample& b, const ImuStepQuality& quality) {
            if (quality.gap > Duration{} || quality.clipped != 0) {
                s.begin = b.stamp;
            }
        }));
    if (s.end - s.begin < Duration::from_seconds(InitializerConfig::kMinDuration_s)) {
        return Status::kNotReady;
    }
    out = s;
    return Status::kOk;
}

Status average_turned_force(const ImuBuffer& buffer, const Stretch& stretch, TurnedForce& out) {
    // Forces in the body frame at the beginning (B0), summed over time by tenths of the stretch.
    std::array<Eigen::Vector3d, kBlocks> impulse;
    impulse.fill(Eigen::Vector3d::Zero());
    std::array<double, kBlocks> length_s{};
    Eigen::Quaterniond q_B0_B = Eigen::Quaterniond::Identity();
    const double block_s = stretch.duration_s() / kBlocks;
    FACET_TRY(buffer.for_each_step(
        stretch.begin, stretch.end, [&](const ImuSample& a, const ImuSample& b, const ImuStepQuality&) {
            const double h = (b.stamp - a.stamp).seconds();
            const Eigen::Vector3d half_turn = 0.25 * h * (a.w_B + b.w_B);
            const double middle_s = (a.stamp - stretch.begin).seconds() + 0.5 * h;
            const auto block =
                static_cast<std::size_t>(std::clamp(static_cast<int>(middle_s / block_s), 0, kBlocks - 1));
            impulse[block] += h * (q_B0_B * (so3_exp(half_turn) * (0.5 * (a.a_B + b.a_B))));
            length_s[block] += h;
            q_B0_B = (q_B0_B * so3_exp(2.0 * half_turn)).normalized();
        }));

    Eigen::Vector3d mean_B0 = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& block : impulse) {
        mean_B0 += block / stretch.duration_s();
    }
    double sum_squares = 0.0;
    int blocks = 0;
    for (std::size_t k = 0; k < impulse.size(); ++k) {
        if (length_s[k] > 0.0) {
            const Eigen::Vector3d force = impulse[k] / length_s[k];
            const double angle = std::atan2(force.cross(mean_B0).norm(), force.dot(mean_B0));
            sum_squares += 0.5 * angle * angle;  // two axes
            ++blocks;
        }
    }
    out.mean_B = q_B0_B.conjugate() * mean_B0;
    out.direction_spread_rad = std::sqrt(sum_squares / std::max(1, blocks));
    return Status::kOk;
}

struct PriorSigmas {
    double tilt_rad;
    double velocity_m_per_s;
    double gyro_bias_rad_per_s;
    double accel_bias_m_per_s2;
};

void fill_prior(const PriorSigmas& sigmas, InitialState& out) {
    out.tilt_sigma_rad = sigmas.tilt_rad;
    const Eigen::Vector3d inverse_W(1.0 / sigmas.tilt_rad, 1.0 / sigmas.tilt_rad, 1.0 / kGaugeYawSigmaRad);
    out.sqrt_information.setZero();
    out.sqrt_information.block<3, 3>(kTheta, kTheta) = inverse_W.asDiagonal() * out.state.q_W_B.toRotationMatrix();
    out.sqrt_information.diagonal().segment<3>(kPos).setConstant(1.0 / kGaugePosSigmaM);
    out.sqrt_information.diagonal().segment<3>(kVel).setConstant(1.0 / sigmas.velocity_m_per_s);
    out.sqrt_information.diagonal().segment<3>(kBiasGyro).setConstant(1.0 / sigmas.gyro_bias_rad_per_s);
    out.sqrt_information.diagonal().segment<3>(kBiasAccel).setConstant(1.0 / sigmas.accel_bias_m_per_s2);
}

/// What is measured at rest is the sum of gravity and bias: r = g e_z x (R theta) + R b, about the axes of W.
/// Horizontal, it ties the tilt to a bias that is known to its own sigma only; vertical, it is the bias.
void tie_tilt_to_bias(double accel_sigma, double bias_sigma, double gravity, InitialState& out) {
    const Eigen::Matrix3d R_W_B = out.state.q_W_B.toRotationMatrix();
    auto& root = out.sqrt_information;
    const Eigen::Matrix3d turned = gravity / accel_sigma * skew(Eigen::Vector3d::UnitZ()) * R_W_B;
    root.block<2, 3>(kTheta, kTheta) = turned.topRows<2>();
    root.block<2, 3>(kTheta, kBiasAccel) = R_W_B.topRows<2>() / accel_sigma;
    const double vertical_sigma = std::min(bias_sigma, std::hypot(accel_sigma, kAccelScaleSigma * gravity));
    const Eigen::Vector3d inverse_W(1.0 / bias_sigma, 1.0 / bias_sigma, 1.0 / vertical_sigma);
    root.block<3, 3>(kBiasAccel, kBiasAccel) = inverse_W.asDiagonal() * R_W_B;
}

void fill_still(const TaperedMeans& means, double gravity, const InitializerConfig& config, InitialState& out) {
    const double force = means.a_B.norm();
    const Eigen::Vector3d up_B = means.a_B / force;
    out.is_still = true;
    out.state.q_W_B = level_attitude(up_B);
    out.state.bias.gyro = means.w_B;
    out.state.bias.accel = (force - gravity) * up_B;
    const double accel_sigma = std::hypot(InitializerConfig::kStillAccelSigma_m_per_s2, means.a_sigma.maxCoeff());
    fill_prior({std::hypot(config.accel_bias_sigma_m_per_s2, accel_sigma) / gravity,
                InitializerConfig::kStillVelocitySigma_m_per_s,
                std::hypot(InitializerConfig::kStillGyroBiasSigma_rad_per_s, means.w_sigma.maxCoeff()),
                config.accel_bias_sigma_m_per_s2},
               out);
    tie_tilt_to_bias(accel_sigma, config.accel_bias_sigma_m_per_s2, gravity, out);
}

/// Means of a calm stretch, whose noise is white.
TaperedMeans means_of(const StretchStatistics& s) {
    const double root_n = std::sqrt(static_cast<double>(s.samples));
    return {s.mean_w_B, s.mean_a_B, s.gyro_std / root_n, s.accel_std / root_n};
}

bool may_be_rest(const Eigen::Vector3d& mean_w_B, const Eigen::Vector3d& mean_a_B, double gravity) {
    return mean_w_B.norm() < kStillGyroMean_rad_per_s &&
           std::abs(mean_a_B.norm() - gravity) < kStillGravityError_m_per_s2;
}

void fill_moving(const TurnedForce& turned, double duration_s, double gravity, const InitializerConfig& config,
                 InitialState& out) {
    const double force = turned.mean_B.norm();
    const double magnitude_error = std::abs(force - gravity) / gravity;
    const double turn_error = 0.5 * duration_s * config.gyro_bias_sigma_rad_per_s;
    const double tilt = std::sqrt(turned.direction_spread_rad * turned.direction_spread_rad +
                                  magnitude_error * magnitude_error + turn_error * turn_error);
    out.state.q_W_B = level_attitude(turned.mean_B / force);
    fill_prior(
        {std::max(tilt, InitializerConfig::kMovingTiltSigma_rad), InitializerConfig::kMovingVelocitySigma_m_per_s,
         config.gyro_bias_sigma_rad_per_s, config.accel_bias_sigma_m_per_s2},
        out);
}

}  // namespace

Eigen::Quaterniond level_attitude(const Eigen::Vector3d& up_B) {
    const auto horizontal = [&](const Eigen::Vector3d& axis) -> Eigen::Vector3d {
        return axis - axis.dot(up_B) * up_B;
    };
    Eigen::Vector3d x_B = horizontal(Eigen::Vector3d::UnitX());
    if (x_B.norm() < kMinHorizontal) {
        x_B = horizontal(Eigen::Vector3d::UnitZ());
    }
    x_B.normalize();
    Eigen::Matrix3d R_W_B;
    R_W_B << x_B.transpose(), up_B.cross(x_B).transpose(), up_B.transpose();
    return Eigen::Quaterniond(R_W_B).normalized();
}

Status initialize_state(const ImuBuffer& buffer, Timestamp stamp, double gravity_m_per_s2,
                        const InitializerConfig& config, InitialState& out, bool may_rest) {
    Stretch stretch;
    StretchStatistics statistics;
    TurnedForce turned;
    FACET_TRY(find_stretch(buffer, stamp, stretch));
    FACET_TRY(stretch_statistics(buffer, stretch.begin, stretch.end, statistics));
    FACET_TRY(average_turned_force(buffer, stretch, turned));
    InitialState result;
    result.is_still = may_rest && statistics.gyro_std.maxCoeff() < kStillGyroStd_rad_per_s &&
                      statistics.accel_std.maxCoeff() < kStillAccelStd_m_per_s2 &&
                      may_be_rest(statistics.mean_w_B, statistics.mean_a_B, gravity_m_per_s2) &&
                      statistics.drift_share(kStillGyroDriftRadPerS, kStillAccelDriftMPerS2) < 1.0;
    if (!result.is_still && turned.mean_B.norm() < kMinForceMPerS2) {
        return Status::kDegenerate;
    }
    if (result.is_still) {
        fill_still(means_of(statistics), gravity_m_per_s2, config, result);
    } else {
        fill_moving(turned, stretch.duration_s(), gravity_m_per_s2, config, result);
    }
    out = result;
    return Status::kOk;
}

Status initialize_shaken(const ImuBuffer& buffer, const RestStretch& rest, double gravity_m_per_s2,
                         const InitializerConfig& config, InitialState& out) {
    TaperedMeans means;
    FACET_TRY(tapered_means(buffer, rest.begin, rest.end, means));
    if (!may_be_rest(means.w_B, means.a_B, gravity_m_per_s2)) {
        return Status::kDegenerate;
    }
    const VibrationShare near_zero = VibrationLearner{}.share();  // nothing has been learnt yet
    means.w_sigma *= std::sqrt(near_zero.gyro);
    means.a_sigma *= std::sqrt(near_zero.accel);
    InitialState result;
    fill_still(means, gravity_m_per_s2, config, result);
    out = result;
    return Status::kOk;
}

}  // namespace facet
