// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/flight_motion.h"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "estimator/geometry/so3.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

constexpr double kLeastDurationS = 5.0;
constexpr double kLeastPathM = 2.0;
constexpr double kLeastTurnedRad = 5.0 * kRadPerDeg;  // about the axis of most change
constexpr double kLeastTiltedRad = 1.0 * kRadPerDeg;  // about the second one
constexpr double kLeastAcceleratedMPerS2 = 0.2;

/// Rotations of the keyframes against their mean: the one from which the mean rotation vector is zero.
std::vector<Eigen::Vector3d> turns(const RecordedFlight& flight) {
    Eigen::Quaterniond mean = flight.keyframes.front().state.q_W_B;
    std::vector<Eigen::Vector3d> out;
    for (int iteration = 0; iteration < 5; ++iteration) {
        out.clear();
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const RecordedKeyframe& keyframe : flight.keyframes) {
            out.push_back(so3_log(mean.conjugate() * keyframe.state.q_W_B));
            sum += out.back();
        }
        mean = (mean * so3_exp(sum / static_cast<double>(out.size()))).normalized();
    }
    return out;
}

}  // namespace

FlightMotion measure_motion(const RecordedFlight& flight) {
    FlightMotion motion;
    const std::vector<RecordedKeyframe>& keyframes = flight.keyframes;
    if (keyframes.size() < 2) {
        return motion;
    }
    motion.duration_s = (keyframes.back().stamp - keyframes.front().stamp).seconds();
    double squares = 0.0;
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        motion.path_m += (keyframes[k].state.p_W_B - keyframes[k - 1].state.p_W_B).norm();
        const double dt = (keyframes[k].stamp - keyframes[k - 1].stamp).seconds();
        squares += (keyframes[k].state.v_W_B - keyframes[k - 1].state.v_W_B).squaredNorm() / dt;
    }
    motion.accelerated_m_per_s2 = std::sqrt(squares / motion.duration_s);
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& turn : turns(flight)) {
        scatter += turn * turn.transpose() / static_cast<double>(keyframes.size());
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter, Eigen::EigenvaluesOnly);
    motion.turned_rad = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().reverse();
    return motion;
}

std::string motion_complaint(const FlightMotion& motion) {
    if (motion.duration_s < kLeastDurationS || motion.path_m < kLeastPathM) {
        return fmt::format(
            "the flight is too short or stands: {:.1f} s and {:.1f} m in motion, of {} s and {} m needed",
            motion.duration_s, motion.path_m, kLeastDurationS, kLeastPathM);
    }
    const Eigen::Vector3d turned_deg = motion.turned_rad / kRadPerDeg;
    if (motion.turned_rad.x() < kLeastTurnedRad || motion.turned_rad.y() < kLeastTiltedRad) {
        return fmt::format(
            "the flight is too straight: its attitude varies by {:.1f}, {:.1f} and {:.1f} deg rms about its three "
            "axes; "
            "fly yaw, pitch and roll",
            turned_deg.x(), turned_deg.y(), turned_deg.z());
    }
    if (motion.accelerated_m_per_s2 < kLeastAcceleratedMPerS2) {
        return fmt::format("the flight is too gentle: {:.2f} m/s^2 rms of {} needed; start, stop and turn back",
                           motion.accelerated_m_per_s2, kLeastAcceleratedMPerS2);
    }
    return {};
}

}  // namespace facet
