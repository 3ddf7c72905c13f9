// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/source_thread.h"

#include <catch2/catch.hpp>

#include "platform/base/spsc_queue.h"
#include "tests/support/scripted_source.h"

namespace facet::source_thread_test {
namespace {

/// Starts at an attempt; then it gives a sample and ends.
class LateSource final : public TriggerSource {
public:
    explicit LateSource(int attempts) : attempts_(attempts) {}
    Status start() override { return ++starts >= attempts_ ? Status::kOk : Status::kNotFound; }
    void stop() override {}
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return {}; }
    std::string_view problem() const override { return ""; }
    Status next(Duration, TriggerEdge& edge) override {
        CHECK(starts >= attempts_);
        if (given_) {
            return Status::kEndOfStream;
        }
        given_ = true;
        edge.stamp = {5};
        return Status::kOk;
    }
    int starts = 0;

private:
    int attempts_;
    bool given_ = false;
};

TEST_CASE("a source that is awaited is tried every half second, and what it gives then is passed on") {
    ManualClock clock;
    LinuxWakeup wakeup;
    SpscQueue<TriggerEdge, 8> queue;
    SourceThread shared("trigger");
    shared.is_awaited = true;
    const std::atomic<bool> stopping{false};
    LateSource source(4);
    pump(source, shared, clock, wakeup, stopping, queue);
    CHECK(source.starts == 4);
    CHECK(clock.now() == Timestamp{2'000'000'000});
    TriggerEdge edge;
    REQUIRE(ok(queue.pop(edge)));
    CHECK(edge.stamp.ns == 5);
    RunEvent event;
    REQUIRE(ok(shared.events.pop(event)));
    CHECK(std::string(event.text.data()) == "trigger: works again");
    CHECK(shared.ended);
}

TEST_CASE("a thread whose source is awaited stops at once") {
    ManualClock clock;
    LinuxWakeup wakeup;
    SpscQueue<TriggerEdge, 8> queue;
    SourceThread shared("trigger");
    shared.is_awaited = true;
    const std::atomic<bool> stopping{true};
    LateSource source(4);
    pump(source, shared, clock, wakeup, stopping, queue);
    CHECK(source.starts == 0);
    CHECK(shared.ended);
}

}  // namespace
}  // namespace facet::source_thread_test
