// SPDX-License-Identifier: BSD-2-Clause
// Poses where gravity is known: a turn about the vertical and a place.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "estimator/geometry/se3.h"

namespace facet {

/// The rotation about z by an angle (rad).
inline Eigen::Matrix3d yaw_matrix(double yaw) {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    Eigen::Matrix3d r;
    r << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
    return r;
}

/// The same angle within half a turn of zero (rad).
inline double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

/// Transform T_A_B between two frames whose z axes are vertical: p_A = Rz(yaw) p_B + p. Tangent order [yaw p], p in A,
/// as in KeyframeView::HeadingAndPlace. Reentrant. No heap.
struct YawPose {
    using Tangent = Eigen::Vector4d;
    using Covariance = Eigen::Matrix4d;

    double yaw = 0.0;                             ///< (rad)
    Eigen::Vector3d p = Eigen::Vector3d::Zero();  ///< (m)

    Eigen::Matrix3d R() const { return yaw_matrix(yaw); }
    YawPose inverse() const { return {-yaw, -(yaw_matrix(-yaw) * p)}; }
    YawPose operator*(const YawPose& o) const { return {wrapped(yaw + o.yaw), R() * o.p + p}; }
    Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return R() * x + p; }
    Se3 operator*(const Se3& o) const { return se3() * o; }

    YawPose box_plus(const Tangent& d) const { return {wrapped(yaw + d[0]), p + d.tail<3>()}; }
    /// The d with other = box_plus(d).
    Tangent box_minus_to(const YawPose& other) const {
        return (Tangent() << wrapped(other.yaw - yaw), other.p - p).finished();
    }

    Se3 se3() const { return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), p}; }
};

/// What an error of T_A_B does to T_A_C = T_A_B T_B_C: J = d T_A_C / d T_A_B = [1 0; z x (p_A_C - p_A_B)  I].
inline Eigen::Matrix4d carried_by(const Eigen::Vector3d& lever_A) {
    Eigen::Matrix4d j = Eigen::Matrix4d::Identity();
    j(1, 0) = -lever_A.y();
    j(2, 0) = lever_A.x();
    return j;
}

/// d of a tangent by turning its place's frame: blockdiag(1, Rz(yaw)).
inline Eigen::Matrix4d turned_by(double yaw) {
    Eigen::Matrix4d j = Eigen::Matrix4d::Identity();
    j.bottomRightCorner<3, 3>() = yaw_matrix(yaw);
    return j;
}

/// The turn about the vertical that best takes rotation a to rotation b: that of Rz(yaw) a closest to b (rad).
inline double yaw_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
    const Eigen::Matrix3d m = b * a.transpose();
    return std::atan2(m(1, 0) - m(0, 1), m(0, 0) + m(1, 1));
}

}  // namespace facet
