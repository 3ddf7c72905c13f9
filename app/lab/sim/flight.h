// SPDX-License-Identifier: BSD-2-Clause
// Flights: smooth paths of the body through a scene, with their exact derivatives.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <utility>
#include <vector>

#include "app/lab/sim/scene.h"
#include "app/lab/sim/spline.h"
#include "estimator/geometry/se3.h"
#include "platform/base/status.h"

namespace facet::sim {

/// Exact motion of the body at one time, world frame unless named otherwise.
struct FlightState {
    Se3 T_W_B;
    Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  ///< (m/s)
    Eigen::Vector3d a_W = Eigen::Vector3d::Zero();  ///< (m/s^2)
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  ///< angular rate in B (rad/s)
};

/// Position and roll-pitch-yaw as one quintic spline: R_W_B = Rz(yaw) Ry(pitch) Rx(roll) R_F_B, F = forward-left-up.
/// R_F_B turns the sensor (x up, y right, z forward, as EuRoC's IMU is mounted) into F. Reentrant. evaluate() uses no
/// heap.
class Flight {
public:
    /// Control points [x y z roll pitch yaw].
    using Spline = QuinticSpline<6>;

    /// One second at the world's origin.
    Flight() : Flight(Spline(1.0, std::vector<Spline::Vector>(6, Spline::Vector::Zero()))) {}
    explicit Flight(Spline spline) : spline_(std::move(spline)) {}

    double duration_s() const { return spline_.duration_s(); }
    FlightState evaluate(double t_s) const;

private:
    Spline spline_;
};

/// How a planned flight turned out.
struct FlightReport {
    double min_clearance_m = 0.0;
    double max_speed_m_per_s = 0.0;
    double max_rate_rad_per_s = 0.0;
    double max_acceleration_m_per_s2 = 0.0;
    double path_m = 0.0;
};
FlightReport inspect_flight(const Flight& flight, const Scene& scene);

enum class FlightKind : std::uint8_t {
    kTour,   ///< legs through the whole flight volume
    kHover,  ///< take-off, then holding a place with 2 to 5 cm of slow wander and little tilt
    kTurn,   ///< the same, and every few seconds a turn on the spot to the left
};

struct FlightPlan {
    FlightKind kind = FlightKind::kTour;
    double duration_s = 30.0;
    double stand_s = 2.5;  ///< exactly motionless from the start
    double max_speed_m_per_s = 1.5;
    double max_rate_rad_per_s = 1.05;
    std::uint64_t seed = 1;
    bool closed = false;  ///< back the way it came after half the time, to stand at the end where it began
};

/// Draws flights from the seed until one keeps the scene's clearance and the plan's limits.
/// @return kDegenerate if none of 20 draws does (output untouched). Heap.
Status plan_flight(const Scene& scene, const FlightPlan& plan, Flight& flight);

}  // namespace facet::sim
