// SPDX-License-Identifier: BSD-2-Clause
// What a CAN frame says about motion: the interface of the protocols.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "drivers/imu_can/can_frame.h"
#include "platform/base/status.h"

namespace facet {

/// What one frame brought: an angular rate, a specific force, or both; in sensor axes, SI units.
struct CanMeasurement {
    std::optional<Eigen::Vector3d> rate;   ///< (rad/s)
    std::optional<Eigen::Vector3d> force;  ///< (m/s^2)
    Duration age;                          ///< how long before the frame's stamp it was measured
    double temperature_c = std::numeric_limits<double>::quiet_NaN();
    std::uint32_t lost = 0;  ///< measurements missing before this one, by the sensor's own count
};

/// Frames that the kernel is to let pass: (id & mask) == (value & mask), extended or not.
struct CanFilter {
    std::uint32_t value = 0;
    std::uint32_t mask = 0;
    bool extended = false;
};

/// One protocol. Thread-bound. Heap in the constructor only.
class CanDecoder {
public:
    virtual ~CanDecoder() = default;

    /// @return kOk with a measurement; kNotFound if the frame says nothing of motion; kNotReady if more frames belong to
    ///         it; kCorrupt if it contradicts itself.
    virtual Status decode(const CanFrame& frame, CanMeasurement& measurement) = 0;
    virtual std::vector<CanFilter> filters() const = 0;
    /// Forgets frames that wait for more.
    virtual void reset() = 0;
};

}  // namespace facet
