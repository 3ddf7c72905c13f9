// SPDX-License-Identifier: BSD-2-Clause
// Ranges of the IMU: what is valid.
#include "estimator/imu/imu_limits.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace facet {

TEST_CASE("the limits are validated field by field") {
    CHECK(ImuLimits{}.validate() == Status::kOk);
    for (const auto field : {&ImuLimits::gyro_range_rad_per_s, &ImuLimits::accel_range_m_per_s2}) {
        for (const double bad : {0.0, -1.0, 1e6, std::nan("")}) {
            ImuLimits limits;
            limits.*field = bad;
            CHECK(limits.validate() == Status::kInvalidArgument);
        }
    }
}

}  // namespace facet
