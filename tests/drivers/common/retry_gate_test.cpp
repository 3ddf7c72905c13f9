// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/retry_gate.h"

#include <catch2/catch.hpp>

namespace facet::retry_gate_test {
namespace {

TEST_CASE("a retry gate opens once a period") {
    RetryGate gate({100});
    CHECK(gate.pass({0}));
    CHECK_FALSE(gate.pass({99}));
    CHECK(gate.pass({100}));
    gate.close({150});
    CHECK_FALSE(gate.pass({249}));
    CHECK(gate.pass({250}));
}

}  // namespace
}  // namespace facet::retry_gate_test
