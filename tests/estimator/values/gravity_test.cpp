// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/values/gravity.h"

#include <catch2/catch.hpp>

#include "tests/support/check_fields.h"

namespace facet::gravity_test {

TEST_CASE("the gravity config is validated field by field") { test::check_fields(kGravityFields); }

}  // namespace facet::gravity_test
