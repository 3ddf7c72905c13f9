// SPDX-License-Identifier: BSD-2-Clause
// Measuring ranges of the IMU, beyond which its readings say only "at least this much".
#pragma once

#include "platform/base/status.h"

namespace facet {

/// One line a field: meaning [unit] [range] and why this default. Usage: a member of the estimator's configuration,
/// given to ImuBuffer::clear() with the rate.
struct ImuLimits {
    double gyro_range_rad_per_s = 17.453;  ///< full scale of a gyroscope axis [0.1, 1000]; ADIS16448: 1000 deg/s
    double accel_range_m_per_s2 = 176.58;  ///< full scale of an accelerometer axis [5, 1e5]; ADIS16448: 18 g

    Status validate() const;
};

}  // namespace facet
