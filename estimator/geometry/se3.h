// SPDX-License-Identifier: BSD-2-Clause
// Rigid transforms and their tangent, order [theta p]: R * Exp(dtheta), p + dp (dp in the target frame).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "estimator/geometry/so3.h"

namespace facet {

/// Rigid transform T_A_B: p_A = q * p_B + p. Invariant: |q| = 1 to rounding.
/// Tangent order [theta p]: box_plus(d) = (q * Exp(d.head<3>()), p + d.tail<3>()): a right perturbation of the rotation
/// and a plain sum for the position, so the position part is expressed in A. Reentrant. No heap.
struct Se3 {
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    Eigen::Vector3d p = Eigen::Vector3d::Zero();

    static Se3 from_matrix(const Eigen::Matrix4d& t) {
        return {Eigen::Quaterniond(Eigen::Matrix3d(t.topLeftCorner<3, 3>())).normalized(), t.topRightCorner<3, 1>()};
    }
    Eigen::Matrix4d matrix() const {
        Eigen::Matrix4d t = Eigen::Matrix4d::Identity();
        t.topLeftCorner<3, 3>() = R();
        t.topRightCorner<3, 1>() = p;
        return t;
    }
    Eigen::Matrix3d R() const { return q.toRotationMatrix(); }

    Se3 inverse() const { return {q.conjugate(), q.conjugate() * (-p)}; }
    Se3 operator*(const Se3& o) const { return {(q * o.q).normalized(), q * o.p + p}; }
    Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return q * x + p; }

    Se3 box_plus(const Eigen::Matrix<double, 6, 1>& d) const {
        return {(q * so3_exp(d.head<3>())).normalized(), p + d.tail<3>()};
    }
    /// The d with other = box_plus(d).
    Eigen::Matrix<double, 6, 1> box_minus_to(const Se3& other) const {
        Eigen::Matrix<double, 6, 1> d;
        d << so3_log(q.conjugate() * other.q), other.p - p;
        return d;
    }
};

}  // namespace facet
