// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/stamp_mapper.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/support/scripted_source.h"

namespace facet::stamp_mapper_test {
namespace {

TEST_CASE("monotonic stamps pass as they are") {
    const ManualClock clock({5});
    StampMapper mapper(clock, ClockDomain::kMonotonic);
    Timestamp stamp{123};
    CHECK(mapper.map(stamp) == Status::kOk);
    CHECK(stamp.ns == 123);
}

TEST_CASE("wall-clock stamps come onto the monotonic clock within a tenth of a second, and follow a step") {
    ManualClock clock({1'000'000'000}, Duration::from_seconds(1.7e9));
    StampMapper mapper(clock, ClockDomain::kRealtime);
    int refused = 0;
    for (int i = 0; i < 400; ++i) {
        if (i == 200) {
            clock.set_realtime_offset(Duration::from_seconds(1.7e9 + 1.0));
        }
        clock.advance({10'000'000});
        Timestamp stamp = clock.read_pair().realtime - Duration{2'000'000};
        if (!ok(mapper.map(stamp))) {
            ++refused;
            CHECK((i < 10 || i >= 200));
            continue;
        }
        if (i < 200) {
            CHECK(std::abs((stamp - clock.now()).ns + 2'000'000) < 1000);
        }
    }
    CHECK(refused > 0);
    CHECK(refused < 20);
}

TEST_CASE("a wall clock that is set forward or back, by seconds or an hour, costs a fifth of a second of stamps") {
    for (const double step_s : {30.0, 3600.0, -10.0, 1.0}) {
        CAPTURE(step_s);
        ManualClock clock({1'000'000'000}, Duration::from_seconds(1.7e9));
        StampMapper mapper(clock, ClockDomain::kRealtime);
        Timestamp last_good;
        double longest_s = 0.0;
        for (int i = 0; i < 1000; ++i) {
            if (i == 500) {
                clock.set_realtime_offset(Duration::from_seconds(1.7e9 + step_s));
            }
            clock.advance({5'000'000});
            Timestamp stamp = clock.read_pair().realtime;
            if (ok(mapper.map(stamp))) {
                CHECK(stamp <= clock.now() + Duration{5'000'000});
                if (i < 500 || i > 540) {
                    CHECK(std::abs((stamp - clock.now()).ns) < 50'000);
                }
                longest_s = i > 100 ? std::max(longest_s, (clock.now() - last_good).seconds()) : 0.0;
                last_good = clock.now();
            }
        }
        CHECK(longest_s < 0.2);
        CHECK((clock.now() - last_good).seconds() < 0.01);
    }
}

TEST_CASE("stamps of a hardware clock come onto the monotonic clock by their earliest arrivals") {
    ManualClock clock({1'000'000'000});
    StampMapper mapper(clock, ClockDomain::kHardware);
    Timestamp stamp;
    for (int i = 0; i < 500; ++i) {
        clock.advance({5'000'000});
        const Timestamp measured = clock.now();
        clock.advance({50'000 + (i % 7 == 0 ? 2'000'000 : 0)});  // seldom late
        stamp = Timestamp{measured.ns - 900'000'000};
        const Status status = mapper.map(stamp);
        CHECK((ok(status) || i < 3));
        if (i > 100) {
            CHECK(std::abs((stamp - measured).ns - 50'000) < 300'000);
        }
    }
}

TEST_CASE("a hardware clock that jumps ahead or back permanently costs a few samples, since arrival shows the step") {
    for (const double step_s : {3600.0, 1.0, -1.0, -3600.0}) {
        CAPTURE(step_s);
        ManualClock clock({9'000'000'000'000});
        StampMapper mapper(clock, ClockDomain::kHardware);
        int refused = 0;
        double worst_s = 0.0;
        for (int i = 0; i < 2000; ++i) {
            clock.advance({5'000'000});
            const Timestamp measured = clock.now();
            clock.advance({50'000 + (i % 7 == 0 ? 2'000'000 : 0)});  // seldom late
            Timestamp stamp{measured.ns - 4'000'000'000'000};
            stamp = i < 1000 ? stamp : stamp + Duration::from_seconds(step_s);
            if (!ok(mapper.map(stamp))) {
                refused += i > 100 ? 1 : 0;
            } else if (i > 100) {
                worst_s = std::max(worst_s, std::abs((stamp - measured).seconds()));
            }
        }
        CHECK(refused <= 5);
        CHECK(worst_s < 0.5e-3);
    }
}

}  // namespace
}  // namespace facet::stamp_mapper_test
