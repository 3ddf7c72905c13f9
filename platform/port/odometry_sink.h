// SPDX-License-Identifier: BSD-2-Clause
// Where estimates go: a flight controller, a log, a bus.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "platform/base/status.h"
#include "platform/base/timestamp.h"

namespace facet {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// What a consumer needs to know of one estimate.
struct Odometry {
    Timestamp stamp;                                             ///< exposure midpoint
    Eigen::Quaterniond q_W_B = Eigen::Quaterniond::Identity();   ///< attitude
    Eigen::Vector3d p_W_B = Eigen::Vector3d::Zero();             ///< position (m)
    Eigen::Vector3d v_W_B = Eigen::Vector3d::Zero();             ///< velocity, in W (m/s)
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();               ///< angular rate, in B (rad/s)
    Matrix6d pose_covariance = Matrix6d::Identity();             ///< [p in W, theta in B] (m^2, rad^2)
    Eigen::Matrix3d v_covariance = Eigen::Matrix3d::Identity();  ///< of v_W_B (m^2/s^2)
    Eigen::Matrix3d w_covariance = Eigen::Matrix3d::Identity();  ///< of w_B (rad^2/s^2)
    int quality = 0;                                             ///< -1 failed, 0 unknown, 1 (worst) to 100 (best)
    std::uint8_t reset_counter = 0;                              ///< raised at every jump
};

/// A consumer. Thread-bound. No heap in send.
class OdometrySink {
public:
    virtual ~OdometrySink() = default;

    /// @return kInvalidArgument if a number is not finite or a variance not positive: nothing sent; kFull if the
    ///         channel is full: dropped; kIo if the channel fails.
    virtual Status send(const Odometry& odometry) = 0;
};

}  // namespace facet
