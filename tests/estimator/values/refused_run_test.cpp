// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/values/refused_run.h"

#include <catch2/catch.hpp>

namespace facet::refused_run_test {
namespace {

Timestamp at_ms(std::int64_t ms) { return Timestamp{ms * 1'000'000}; }

}  // namespace

TEST_CASE("stamps that go on for half a second are a clock's", "[refused_run]") {
    RefusedRun run;
    for (int k = 0; k <= 50; ++k) {
        CHECK_FALSE(run.is_clock());
        run.add(at_ms(1000 + 10 * k));
    }
    CHECK(run.is_clock());
    CHECK(run.clock_begin() == at_ms(1000));
    CHECK(run.newest() == at_ms(1500));
    CHECK(run.take_s() == Approx(0.5));
    CHECK_FALSE(run.is_clock());
    CHECK(run.take_s() == 0.0);
}

TEST_CASE("stamps all over the place cover no time, and are no clock", "[refused_run]") {
    RefusedRun run;
    for (int k = 0; k < 100; ++k) {
        run.add(at_ms(k % 2 == 0 ? 1000 + 10 * k : 50'000));
        CHECK_FALSE(run.is_clock());
    }
    CHECK(run.take_s() == 0.0);
}

TEST_CASE("a clock begins after the last step that is none of a clock", "[refused_run]") {
    RefusedRun run;
    for (const int jump_ms : {0, 5000, 3000}) {
        for (int k = 0; k <= 40; ++k) {
            run.add(at_ms(jump_ms + 10 * k));
            CHECK_FALSE(run.is_clock());
        }
    }
    for (int k = 41; k <= 50; ++k) {
        run.add(at_ms(3000 + 10 * k));
    }
    CHECK(run.is_clock());
    CHECK(run.clock_begin() == at_ms(3000));
}

}  // namespace facet::refused_run_test
