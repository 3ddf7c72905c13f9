// SPDX-License-Identifier: BSD-2-Clause
// A plane as a variable: unit normal and offset, with a tangent of three.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "estimator/geometry/so3.h"

namespace facet {

/// Degrees of freedom of a plane: tangent [v h], v a turn of the normal (rad), h a shift along it (m).
inline constexpr int kPlaneDim = 3;

/// The plane n . (p - o) = h about a fixed anchor o near its points, so that n and h stay nearly independent at any
/// distance from the world's origin; the usual n . p = d has d = h + n . o. The normal is the third axis of a rotation
/// that carries the basis of its tangent space along: n(v) = R Exp([v_0 v_1 0]) e_z, a retraction of S2 without a
/// singular direction. [Kaess15] for the minimal update. Reentrant. No heap.
struct Plane {
    using Tangent = Eigen::Matrix<double, kPlaneDim, 1>;

    Eigen::Quaterniond q_W_P = Eigen::Quaterniond::Identity();
    double h = 0.0;                                      ///< (m)
    Eigen::Vector3d anchor_W = Eigen::Vector3d::Zero();  ///< o (m)

    /// The plane n . p = d, anchored at `anchor_W`.
    static Plane from(const Eigen::Vector3d& normal_W, double distance_m, const Eigen::Vector3d& anchor_W) {
        const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal_W);
        return {q.normalized(), distance_m - normal_W.normalized().dot(anchor_W), anchor_W};
    }

    Eigen::Vector3d normal_W() const { return q_W_P * Eigen::Vector3d::UnitZ(); }
    double distance_m() const { return h + normal_W().dot(anchor_W); }
    /// Signed distance of a point from the plane (m).
    double height(const Eigen::Vector3d& p_W) const { return normal_W().dot(p_W - anchor_W) - h; }

    Plane box_plus(const Tangent& d) const {
        return {(q_W_P * so3_exp({d(0), d(1), 0.0})).normalized(), h + d(2), anchor_W};
    }
    /// The d with other = box_plus(d); planes with the same anchor.
    Tangent box_minus_to(const Plane& other) const {
        Tangent d;
        d << so3_log(q_W_P.conjugate() * other.q_W_P).head<2>(), other.h - h;
        return d;
    }
    /// R (v x e_z) = R (v_1, -v_0, 0).
    Eigen::Matrix<double, 3, 2> d_normal_d_v() const {
        const Eigen::Matrix3d R = q_W_P.toRotationMatrix();
        Eigen::Matrix<double, 3, 2> d;
        d << -R.col(1), R.col(0);
        return d;
    }
};

}  // namespace facet
