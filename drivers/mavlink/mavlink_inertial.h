// SPDX-License-Identifier: BSD-2-Clause
// The messages that carry readings of a flight controller's inertial sensor.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "drivers/mavlink/mavlink_packet.h"

namespace facet {

enum class MavlinkImuMessage : std::uint8_t { kHighresImu, kRawImu, kScaledImu, kScaledImu2, kScaledImu3 };

constexpr MavlinkId id_of(MavlinkImuMessage message) {
    switch (message) {
        case MavlinkImuMessage::kHighresImu: return MavlinkId::kHighresImu;
        case MavlinkImuMessage::kRawImu: return MavlinkId::kRawImu;
        case MavlinkImuMessage::kScaledImu: return MavlinkId::kScaledImu;
        case MavlinkImuMessage::kScaledImu2: return MavlinkId::kScaledImu2;
        case MavlinkImuMessage::kScaledImu3: return MavlinkId::kScaledImu3;
    }
    return MavlinkId::kHighresImu;
}

constexpr const char* to_string(MavlinkImuMessage message) {
    constexpr const char* kNames[] = {"HIGHRES_IMU", "RAW_IMU", "SCALED_IMU", "SCALED_IMU2", "SCALED_IMU3"};
    return kNames[static_cast<std::size_t>(message)];
}

/// One reading in SI units and in B's axes, which are x forward, y left, z up: those of the messages (forward, right,
/// down) times diag(1, -1, -1).
struct MavInertial {
    std::uint64_t time_us = 0;  ///< since the controller's boot; of SCALED_IMU to the millisecond
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();
    Eigen::Vector3d a_B = Eigen::Vector3d::Zero();
    std::uint8_t id = 0;      ///< which of the controller's sensors, where the message says so
    bool is_complete = true;  ///< both are new since the message before
    double temperature_c = std::numeric_limits<double>::quiet_NaN();
};

/// RAW_IMU as ArduPilot fills it, in the units of SCALED_IMU: milli-g of 9.80665 m/s^2 and mrad/s. Reentrant. No heap.
/// @param packet  of a MavlinkImuMessage
MavInertial decode_inertial(const MavlinkPacket& packet);

/// Standard deviation that the message's rounding adds to each reading, as a noise density at that rate: a step q has
/// a variance of q^2 / 12, and a density of sqrt(q^2 / 12 / rate). Zero for HIGHRES_IMU. Reentrant.
double rounding_of_rates(MavlinkImuMessage message, double rate_hz);   ///< (rad/s/sqrt(Hz))
double rounding_of_forces(MavlinkImuMessage message, double rate_hz);  ///< (m/s^2/sqrt(Hz))

}  // namespace facet
