// SPDX-License-Identifier: BSD-2-Clause
// Where estimates go: a flight controller, a log, a bus.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>

#include "platform/base/status.h"
#include "platform/base/timestamp.h"

namespace facet {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The estimator's state, as consumers tell it apart.
enum class SinkState : std::uint8_t { kInit, kTracking, kDegraded, kLost };

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
    SinkState state = SinkState::kTracking;
    std::uint32_t reasons = 0;  ///< of the state, bits as in health.csv
    /// Whether the pose in the map of places is known; then p_M = Rz(map_yaw) p_W + map_p.
    bool is_in_map = false;
    double map_yaw = 0.0;                             ///< (rad)
    Eigen::Vector3d map_p = Eigen::Vector3d::Zero();  ///< (m)
};

/// A change of the estimator's state, for those who decide whether to fly.
struct StateChange {
    SinkState state = SinkState::kInit;
    std::array<char, 51> text{};  ///< in words, zero-terminated
    std::uint32_t reasons = 0;    ///< bits as in health.csv
};

/// Distances all around the vehicle, horizontally.
struct ObstacleRanges {
    static constexpr std::size_t kSectors = 72;

    Timestamp stamp;  ///< of the pose they were measured from
    /// Sector k is 5 degrees wide; its middle lies 5 k degrees clockwise, as seen from above, of the body's x axis.
    /// Infinite: known to be free up to max_range_m. NaN: nothing is known there, which is not the same as nothing
    /// being there.
    std::array<float, kSectors> range_m{};
    double max_range_m = 0.0;  ///< what lies farther away was not looked for
};

/// A consumer. Thread-bound. No heap in any of these functions, none of which blocks.
class OdometrySink {
public:
    virtual ~OdometrySink() = default;

    /// @return kInvalidArgument if a number is not finite or a variance not positive: nothing sent; kFull if the
    ///         channel is full: dropped; kIo if the channel fails.
    virtual Status send(const Odometry& odometry) = 0;

    // What not every consumer has a use for:

    virtual void report(const StateChange& /*change*/) {}
    /// @return as send()
    virtual Status send_ranges(const ObstacleRanges& /*ranges*/) { return Status::kOk; }
    /// Does what is due between estimates, such as answering what has arrived.
    virtual void service() {}
    /// How soon after the last call service() has to be called again; zero: never.
    virtual Duration service_period() const { return {}; }
};

}  // namespace facet
