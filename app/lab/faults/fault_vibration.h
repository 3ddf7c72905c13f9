// SPDX-License-Identifier: BSD-2-Clause
// The vibration that a fault asks for: what it adds to inertial samples, and the angle by which it turns the body.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "app/lab/faults/fault.h"
#include "app/lab/faults/rotor_vibration.h"

namespace facet {

/// A vibration on the clock of the faults. Thread-bound. Heap in the constructor only.
class FaultVibration {
public:
    /// @param fault  of kind kVibration
    /// @param index  of the fault: no two of a run shake alike
    FaultVibration(const Fault& fault, std::size_t index);

    /// [w a] about and along the axes of the IMU (rad/s, m/s^2); fast for times in order.
    RotorVibration::Vector6 at(Duration t);

private:
    double factor_;
    RotorVibration rotors_;
};

/// The angle to which the gyroscope's part of a vibration w adds up,
///   d theta / dt = w - theta / tau,   tau = 1 s:
/// its integral without what lies below 0.16 Hz, where the vibration has nothing and an integral would wander. As long
/// as it is small, the body's attitude is R Exp(theta) where it would be R. A fault from the start has gone on for some
/// tau when it is first asked for; one with a START begins at zero there. Thread-bound. Heap in the constructor only.
class VibrationAngle {
public:
    /// As FaultVibration, and the same vibration.
    VibrationAngle(const Fault& fault, std::size_t index);

    /// About the axes of the IMU (rad); zero before it begins; fast for times in order.
    Eigen::Vector3d at(Duration t);

private:
    void begin();

    FaultVibration vibration_;
    Duration begin_;
    Duration now_;  ///< at the end of the last whole step
    Eigen::Vector3d rate_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d angle_ = Eigen::Vector3d::Zero();
};

}  // namespace facet
