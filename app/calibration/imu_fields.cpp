// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/imu_fields.h"

#include <fmt/core.h>

#include <Eigen/SVD>
#include <algorithm>

#include "app/calibration/calibration_fields.h"

namespace facet {
namespace {

constexpr double kMostScale = 0.5;     // of an axis, either way
constexpr double kMostFeeling = 0.05;  // (rad/s)/(m/s^2): half a radian per second by gravity alone

/// A matrix below a map that need not be there; `fallback` without it.
Eigen::Matrix3d matrix_or(const YamlNode& node, const char* group, const char* key, const Eigen::Matrix3d& fallback) {
    if (group != nullptr) {
        return node.has(group) ? matrix_or(node.at(group), nullptr, key, fallback) : fallback;
    }
    return node.has(key) ? node.at(key).matrix3() : fallback;
}

Eigen::Matrix3d rotation_or_identity(const YamlNode& node, const char* group, const char* key) {
    if (group != nullptr) {
        return node.has(group) ? rotation_or_identity(node.at(group), nullptr, key) : Eigen::Matrix3d::Identity();
    }
    return node.has(key) ? nearest_rotation(node.at(key).matrix3(), node.at(key)) : Eigen::Matrix3d::Identity();
}

}  // namespace

void read_noise(const YamlNode& node, double ImuNoise::*member, ImuNoise& noise) {
    const auto* const field =
        std::ranges::find(kImuNoiseFields, ParameterField<ImuNoise>::Member(member), &ParameterField<ImuNoise>::member);
    noise.*member = node.number();
    node.require_in_range(noise.*member, field->min, field->max, field->unit);
}

ImuNoise read_imu_noise(const YamlNode& imu, const std::string& rate_key) {
    ImuNoise noise;
    read_noise(imu.at("gyroscope_noise_density"), &ImuNoise::gyro_noise_rad_per_s_per_sqrt_hz, noise);
    read_noise(imu.at("gyroscope_random_walk"), &ImuNoise::gyro_walk_rad_per_s2_per_sqrt_hz, noise);
    read_noise(imu.at("accelerometer_noise_density"), &ImuNoise::accel_noise_m_per_s2_per_sqrt_hz, noise);
    read_noise(imu.at("accelerometer_random_walk"), &ImuNoise::accel_walk_m_per_s3_per_sqrt_hz, noise);
    read_noise(imu.at(rate_key), &ImuNoise::rate_hz, noise);
    return noise;
}

ImuModel checked_imu_model(const Eigen::Matrix3d& M_a, const Eigen::Matrix3d& M_w, const Eigen::Matrix3d& M_g,
                           const YamlNode& blame) {
    const auto check = [&](const Eigen::Matrix3d& m, const char* what) {
        // A gyroscope's chip may be turned as a whole; what a rotation leaves must be near one.
        const Eigen::Vector3d scales = Eigen::JacobiSVD<Eigen::Matrix3d>(m).singularValues();
        if (!((scales.array() - 1.0).abs().maxCoeff() <= kMostScale) || m.determinant() < 0.0) {
            blame.fail(fmt::format("scale and misalignment of the {} are off by more than a half, or mirror it", what));
        }
    };
    check(M_a, "accelerometer");
    check(M_w, "gyroscope");
    if (!(M_g.cwiseAbs().maxCoeff() <= kMostFeeling)) {
        blame.fail(
            fmt::format("the gyroscope's sensitivity to acceleration is above {} (rad/s)/(m/s^2)", kMostFeeling));
    }
    return {M_a, M_w, M_g};
}

ImuModel read_imu_model(const YamlNode& imu) {
    const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d zero = Eigen::Matrix3d::Zero();
    if (imu.has("accelerometers") || imu.has("gyroscopes")) {
        const Eigen::Matrix3d C_gyro_i = rotation_or_identity(imu, "gyroscopes", "C_gyro_i");
        return checked_imu_model(matrix_or(imu, "accelerometers", "M", identity),
                                 matrix_or(imu, "gyroscopes", "M", identity) * C_gyro_i,
                                 matrix_or(imu, "gyroscopes", "A", zero) * C_gyro_i, imu);
    }
    return checked_imu_model(
        matrix_or(imu, nullptr, "Ta", identity) * rotation_or_identity(imu, nullptr, "R_IMUtoACC"),
        matrix_or(imu, nullptr, "Tw", identity) * rotation_or_identity(imu, nullptr, "R_IMUtoGYRO"),
        matrix_or(imu, nullptr, "Tg", zero), imu);
}

}  // namespace facet
