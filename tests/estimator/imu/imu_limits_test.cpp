// SPDX-License-Identifier: BSD-2-Clause
// Ranges of the IMU: what is valid.
#include "estimator/imu/imu_limits.h"

#include <catch2/catch.hpp>

#include "tests/support/check_fields.h"

namespace facet {

TEST_CASE("the limits are validated field by field") { test::check_fields(kImuLimitFields); }

}  // namespace facet
