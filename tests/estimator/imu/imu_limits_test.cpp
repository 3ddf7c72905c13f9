// SPDX-License-Identifier: BSD-2-Clause
// Ranges of the IMU: what is valid.
#include "estimator/imu/imu_limits.h"

#include <catch2/catch.hpp>

#include "tests/support/check_fields.h"

namespace facet::imu_limits_test {

TEST_CASE("an axis is clipped from 90 % of its range on, either way") {
    ImuLimits limits;
    limits.gyro_range_rad_per_s = 10.0;
    limits.accel_range_m_per_s2 = 100.0;
    CHECK(limits.clipped_axes({{1}, {8.99, -8.99, 0.0}, {89.9, -89.9, 0.0}}) == 0);
    CHECK(limits.clipped_axes({{1}, {9.0, 0.0, -50.0}, {0.0, -90.0, 0.0}}) == 0x15);
}

TEST_CASE("the limits are validated field by field") { test::check_fields(kImuLimitFields); }

}  // namespace facet::imu_limits_test
