// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/device_life.h"

#include <catch2/catch.hpp>

#include "tests/support/scripted_source.h"

namespace facet::device_life_test {
namespace {

/// A device that opens unless the test says otherwise.
class FakeDevice final : public Reopenable {
public:
    Status open(std::string& problem) override {
        ++attempts;
        if (!ok(answer)) {
            problem = "dev0: attempt " + std::to_string(attempts);
            return answer;
        }
        is_open = true;
        return Status::kOk;
    }
    void close() override { is_open = false; }

    Status answer = Status::kOk;
    int attempts = 0;
    bool is_open = false;
};

/// One call of a source's next() in which the device answers so; what it answers does not matter if it is not open.
Status ask(DeviceLife& life, Status answer) {
    return life.next("dev0", [answer] { return answer; });
}
/// As above, of an open device that has nothing.
Status ask(DeviceLife& life) { return ask(life, Status::kNotReady); }
/// Whether the device is asked: it is open, or was opened by this call.
bool is_asked(DeviceLife& life) {
    bool asked = false;
    (void)life.next("dev0", [&] {
        asked = true;
        return Status::kNotReady;
    });
    return asked;
}

struct DeviceUnderTest {
    ManualClock clock{{1'000}};
    FakeDevice device;
    SourceCounters counters;
    DeviceLife life{device, clock, {100}, counters};
};

TEST_CASE("a device is opened once by start and closed by stop, and only in between is it ready") {
    DeviceUnderTest d;
    CHECK_FALSE(is_asked(d.life));
    CHECK_FALSE(d.life.is_started());
    CHECK(d.life.start() == Status::kOk);
    CHECK(d.life.start() == Status::kOk);
    CHECK(d.device.attempts == 1);
    CHECK(d.life.is_started());
    CHECK(is_asked(d.life));
    d.life.stop();
    d.life.stop();
    CHECK_FALSE(d.device.is_open);
    CHECK_FALSE(is_asked(d.life));
    CHECK(d.life.start() == Status::kOk);
    CHECK(d.device.attempts == 2);
    CHECK(d.counters.errors == 0);
}

TEST_CASE("a start that fails passes on why, leaves nothing open and is not retried by itself") {
    DeviceUnderTest d;
    // A device that fails half-way through its configuration.
    d.device.is_open = true;
    d.device.answer = Status::kInvalidArgument;
    CHECK(d.life.start() == Status::kInvalidArgument);
    CHECK(d.life.problem() == "dev0: attempt 1");
    CHECK_FALSE(d.device.is_open);
    d.clock.advance({1'000});
    CHECK_FALSE(is_asked(d.life));
    CHECK(d.device.attempts == 1);
    CHECK(d.counters.errors == 0);  // no outage: it has never worked
    d.device.answer = Status::kOk;
    CHECK(d.life.start() == Status::kOk);
    CHECK(d.life.problem().empty());
}

TEST_CASE("a device that is open but silent is reopened at once, then every retry period") {
    constexpr std::int64_t kFirst = DeviceLife::kFirstSample.ns;
    ManualClock clock{{1'000}};
    FakeDevice device;
    SourceCounters counters;
    DeviceLife life(device, clock, {100}, counters, {50});
    REQUIRE(ok(life.start()));
    // GIVEN a device that has just been opened, it has time for its first sample
    clock.advance({kFirst});
    CHECK(ask(life) == Status::kNotReady);
    life.works();
    clock.advance({50});
    CHECK(ask(life) == Status::kNotReady);
    // WHEN it has worked and says nothing more THEN it is reopened without a pause
    clock.advance({2'000'000});
    CHECK(ask(life) == Status::kIo);
    CHECK(life.problem() == "dev0: no data for 2 ms");
    CHECK_FALSE(device.is_open);
    CHECK(ask(life) == Status::kNotReady);
    CHECK(is_asked(life));
    CHECK(device.attempts == 2);
    CHECK(counters.errors == 1);
    // AND again only when it has had time, at most once every retry period
    clock.advance({kFirst + 1});
    CHECK(ask(life) == Status::kIo);
    CHECK(is_asked(life));
    life.works();
    clock.advance({51});
    CHECK(ask(life) == Status::kIo);
    CHECK_FALSE(is_asked(life));
    clock.advance({49});
    CHECK(is_asked(life));
    CHECK(counters.errors == 2);
    CHECK(counters.recoveries == 1);
    // Without a limit nothing is silent.
    DeviceLife patient(device, clock, {100}, counters);
    REQUIRE(ok(patient.start()));
    clock.advance({100 * kFirst});
    CHECK(ask(patient) == Status::kNotReady);
}

TEST_CASE("whatever is no good sample is silence, and the last reason is in the words") {
    for (const Status useless : {Status::kCorrupt, Status::kNotReady, Status::kOutOfOrder}) {
        CAPTURE(to_string(useless));
        ManualClock clock{{1'000}};
        FakeDevice device;
        SourceCounters counters;
        DeviceLife life(device, clock, {100}, counters, {50});
        REQUIRE(ok(life.start()));
        CHECK(ask(life, Status::kOk) == Status::kOk);
        CHECK(counters.delivered == 1);
        clock.advance({50});
        life.refuse("all are bad");
        CHECK(ask(life, useless) == useless);
        clock.advance({1'000'000});
        CHECK(ask(life, useless) == Status::kIo);
        CHECK(life.problem() == "dev0: no good data for 1 ms: all are bad");
        CHECK_FALSE(device.is_open);
        CHECK(ask(life, Status::kOk) == Status::kOk);
        CHECK(counters.errors == 1);
        CHECK(counters.recoveries == 1);
        clock.advance({2'000'000});
        CHECK(ask(life) == Status::kIo);
        CHECK(life.problem() == "dev0: no data for 2 ms");
    }
}

TEST_CASE("a device that fails is closed and reopened, at most once every retry period") {
    DeviceUnderTest d;
    REQUIRE(ok(d.life.start()));
    CHECK(d.life.fail("dev0: gone") == Status::kIo);
    CHECK_FALSE(d.device.is_open);
    CHECK(d.life.is_started());
    // WHEN the device stays away
    d.device.answer = Status::kNotFound;
    d.clock.advance({99});
    CHECK_FALSE(is_asked(d.life));
    CHECK(d.device.attempts == 1);
    CHECK(d.life.problem() == "dev0: gone");
    d.clock.advance({1});
    CHECK(ask(d.life) == Status::kIo);
    CHECK(d.life.problem() == "dev0: attempt 2");
    CHECK_FALSE(is_asked(d.life));
    // THEN the next attempt is a period after the last one
    d.device.answer = Status::kOk;
    d.clock.advance({99});
    CHECK_FALSE(is_asked(d.life));
    d.clock.advance({1});
    CHECK(is_asked(d.life));
    CHECK(d.device.attempts == 3);
    CHECK(d.device.is_open);
}

TEST_CASE("an outage is one error, and one recovery when a good sample ends it") {
    DeviceUnderTest d;
    REQUIRE(ok(d.life.start()));
    d.life.works();
    CHECK(d.counters.recoveries == 0);
    CHECK(d.life.fail("dev0: gone") == Status::kIo);
    d.device.answer = Status::kIo;
    d.clock.advance({100});
    CHECK(ask(d.life) == Status::kIo);
    d.device.answer = Status::kOk;
    d.clock.advance({100});
    CHECK(is_asked(d.life));
    CHECK(d.counters.errors == 1);
    CHECK(d.counters.recoveries == 0);  // open, but no sample yet
    d.life.works();
    d.life.works();
    CHECK(d.counters.recoveries == 1);
    CHECK(d.life.problem() == "dev0: attempt 2");
    CHECK(d.life.fail("dev0: gone") == Status::kIo);
    CHECK(d.counters.errors == 2);
}

TEST_CASE("a device that recovers by itself stays open during its outage") {
    DeviceUnderTest d;
    REQUIRE(ok(d.life.start()));
    CHECK(d.life.fail_without_closing("dev0: restarts") == Status::kIo);
    CHECK(d.device.is_open);
    CHECK(is_asked(d.life));
    d.life.works();
    CHECK(d.device.attempts == 1);
    CHECK(d.counters.errors == 1);
    CHECK(d.counters.recoveries == 1);
}

TEST_CASE("stop forgets an outage: what works after the next start has not recovered") {
    DeviceUnderTest d;
    REQUIRE(ok(d.life.start()));
    CHECK(d.life.fail("dev0: gone") == Status::kIo);
    d.life.stop();
    d.clock.advance({1'000});
    CHECK_FALSE(is_asked(d.life));
    REQUIRE(ok(d.life.start()));
    CHECK(d.life.problem().empty());
    d.life.works();
    CHECK(d.counters.errors == 1);
    CHECK(d.counters.recoveries == 0);
}

}  // namespace
}  // namespace facet::device_life_test
