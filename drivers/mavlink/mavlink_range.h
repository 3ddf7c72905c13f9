// SPDX-License-Identifier: BSD-2-Clause
// The message that carries readings of a flight controller's range finder.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "drivers/mavlink/mavlink_packet.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Which sensor, and where it is.
struct MavlinkRangeOptions {
    std::uint8_t id = 0;                                 ///< of the sensor
    Duration latency;                                    ///< from measurement to stamp; subtracted from the stamps
    Eigen::Vector3d place_B = Eigen::Vector3d::Zero();   ///< (m)
    Eigen::Vector3d down_B = -Eigen::Vector3d::UnitZ();  ///< its beam's direction, a unit vector
};

/// DISTANCE_SENSOR, as it came.
struct MavDistance {
    std::uint32_t time_ms = 0;  ///< since the controller's boot
    std::uint16_t min_cm = 0;
    std::uint16_t max_cm = 0;
    std::uint16_t distance_cm = 0;
    std::uint8_t id = 0;
    std::uint8_t orientation = 0;  ///< MAV_SENSOR_ORIENTATION
    std::uint8_t quality = 0;      ///< percent; 0: unknown, 1: invalid

    /// It looks down, and its reading is one: inside its range, and not called invalid.
    bool is_of_ground() const {
        constexpr std::uint8_t kPitch270 = 25;
        constexpr std::uint8_t kInvalid = 1;
        return orientation == kPitch270 && quality != kInvalid && distance_cm > min_cm && distance_cm < max_cm;
    }
};

/// Reentrant. No heap.
MavDistance decode_distance(const MavlinkPayload& payload);

}  // namespace facet
