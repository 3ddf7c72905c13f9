// SPDX-License-Identifier: BSD-2-Clause
// Interface of the CAN protocols: turns frames into inertial measurements.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "drivers/common/can_frame.h"
#include "platform/base/status.h"

namespace facet {

/// The content of one frame: an angular rate, a specific force, or both; in sensor axes, SI units.
struct CanMeasurement {
    std::optional<Eigen::Vector3d> rate;   ///< (rad/s)
    std::optional<Eigen::Vector3d> force;  ///< (m/s^2)
    Duration age;                          ///< time from the measurement to the frame's stamp
    double temperature_c = std::numeric_limits<double>::quiet_NaN();
    std::uint32_t lost = 0;  ///< measurements missing before this one, by the sensor's own count
};

/// One protocol. Thread-bound. Heap in the constructor only.
class CanDecoder {
public:
    virtual ~CanDecoder() = default;

    /// @return kOk with a measurement; kNotFound if the frame has no inertial data; kNotReady if more frames are
    ///         needed;
    ///         kCorrupt if the data contradict themselves
    virtual Status decode(const CanFrame& frame, CanMeasurement& measurement) = 0;
    virtual std::vector<CanFilter> filters() const = 0;
    /// Forgets incomplete transfers.
    virtual void reset() = 0;
};

}  // namespace facet
