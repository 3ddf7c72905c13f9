// SPDX-License-Identifier: BSD-2-Clause
// The rotation group SO(3): exponential, logarithm and right Jacobians, perturbation on the right.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace facet {

/// Skew-symmetric matrix: skew(a) * b = a x b.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
    Eigen::Matrix3d m;
    m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
    return m;
}

/// Exp: R^3 -> SO(3) as a unit quaternion. Taylor to order 4 in |theta| below 1e-3 rad (error < 1e-15).
inline Eigen::Quaterniond so3_exp(const Eigen::Vector3d& theta) {
    const double angle2 = theta.squaredNorm();
    double half_sinc = 0.0;
    double cos_half = 0.0;
    if (angle2 < 1e-6) {
        half_sinc = 0.5 - angle2 / 48.0 + angle2 * angle2 / 3840.0;
        cos_half = 1.0 - angle2 / 8.0 + angle2 * angle2 / 384.0;
    } else {
        const double angle = std::sqrt(angle2);
        half_sinc = std::sin(0.5 * angle) / angle;
        cos_half = std::cos(0.5 * angle);
    }
    return {cos_half, half_sinc * theta.x(), half_sinc * theta.y(), half_sinc * theta.z()};
}

/// Log: SO(3) -> R^3, |theta| <= pi (rad). Accurate near 0 and near pi because it works on the quaternion's half angle.
inline Eigen::Vector3d so3_log(const Eigen::Quaterniond& q) {
    const double sign = q.w() < 0.0 ? -1.0 : 1.0;
    const Eigen::Vector3d v = sign * q.vec();
    const double n = v.norm();
    const double w = sign * q.w();
    if (n < 1e-7) {
        return (2.0 / w) * (1.0 - n * n / (3.0 * w * w)) * v;
    }
    return (2.0 * std::atan2(n, w) / n) * v;
}

/// Right Jacobian Jr: Exp(theta + d) = Exp(theta) * Exp(Jr(theta) * d) + O(|d|^2).   [Forster17] eq. (8)
/// Taylor to order 3 in |theta| below 1e-3 rad.
inline Eigen::Matrix3d so3_right_jacobian(const Eigen::Vector3d& theta) {
    const double angle2 = theta.squaredNorm();
    const Eigen::Matrix3d k = skew(theta);
    double a = 0.0;
    double b = 0.0;
    if (angle2 < 1e-6) {
        a = 0.5 - angle2 / 24.0;
        b = 1.0 / 6.0 - angle2 / 120.0;
    } else {
        const double angle = std::sqrt(angle2);
        a = (1.0 - std::cos(angle)) / angle2;
        b = (angle - std::sin(angle)) / (angle2 * angle);
    }
    return Eigen::Matrix3d::Identity() - a * k + b * k * k;
}

/// Inverse of the right Jacobian: Log(Exp(theta) * Exp(d)) = theta + Jr^-1(theta) * d + O(|d|^2).
/// Valid for |theta| < pi. [Forster17] eq. (9); Taylor to order 4 in |theta| below 1e-2 rad.
inline Eigen::Matrix3d so3_right_jacobian_inverse(const Eigen::Vector3d& theta) {
    const double angle2 = theta.squaredNorm();
    const Eigen::Matrix3d k = skew(theta);
    double c = 0.0;
    if (angle2 < 1e-4) {
        c = 1.0 / 12.0 + angle2 / 720.0 + angle2 * angle2 / 30240.0;
    } else {
        const double angle = std::sqrt(angle2);
        c = 1.0 / angle2 - (1.0 + std::cos(angle)) / (2.0 * angle * std::sin(angle));
    }
    return Eigen::Matrix3d::Identity() + 0.5 * k + c * k * k;
}

}  // namespace facet
