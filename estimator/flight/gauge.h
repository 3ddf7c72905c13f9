// SPDX-License-Identifier: BSD-2-Clause
// What a window cannot know of where it is: yaw and place.
#pragma once

#include <Eigen/Core>

#include "estimator/api/belief.h"

namespace facet {

/// Covariance of [yaw p] common to all of a window, rad and m, the yaw about `origin_W`. Inside the window both are
/// taken for known. Reentrant. No heap.
struct Gauge {
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
    Eigen::Vector3d origin_W = Eigen::Vector3d::Zero();

    /// The same, with the yaw about another point.
    Gauge about(const Eigen::Vector3d& p_W) const {
        Eigen::Matrix4d moved = Eigen::Matrix4d::Identity();
        moved.block<3, 1>(1, 0) = Eigen::Vector3d::UnitZ().cross(p_W - origin_W);
        return {moved * covariance * moved.transpose(), p_W};
    }
    void add(const Gauge& other) {
        *this = about(other.origin_W);
        covariance += other.covariance;
    }
};

/// What a state does not know of its yaw and place.
inline Gauge gauge_of(const Belief& b) {
    static_assert(kTheta == 0 && kPos == 3);
    Eigen::Matrix<double, 4, 6> d = Eigen::Matrix<double, 4, 6>::Zero();
    d.topLeftCorner<1, 3>() = b.state.q_W_B.toRotationMatrix().row(2);
    d.bottomRightCorner<3, 3>().setIdentity();
    return {d * b.covariance.topLeftCorner<6, 6>() * d.transpose(), b.state.p_W_B};
}

}  // namespace facet
