// SPDX-License-Identifier: BSD-2-Clause
#include "tests/support/scripted_source.h"

#include <catch2/catch.hpp>

#include "tests/port_conformance/source_conformance.h"

namespace facet::scripted_source_test {
namespace {

/// The scripted source with a script that grows as the suite asks.
template <class Base, class Sample>
class ScriptedHarness final : public test::SourceHarness<Base, Sample> {
public:
    Base& source() override { return source_; }
    void offer(int count) override {
        for (int i = 0; i < count; ++i) {
            if (broken_) {
                source_.add_failure(Status::kIo, "scripted: unplugged");
            } else {
                Sample sample;
                sample.stamp = {stamp_ns_ += 1'000'000};
                source_.add(sample);
            }
        }
    }
    test::Hook offer_corrupt() override {
        source_.add_failure(Status::kCorrupt);
        return test::Hook::kDone;
    }
    test::Hook offer_ahead() override { return test::Hook::kCannot; }  // it has no clock
    test::Hook break_device() override {
        broken_ = true;
        offer(1);
        return test::Hook::kDone;
    }
    void repair_device() override { broken_ = false; }
    test::Hook judges_silence() override { return test::Hook::kCannot; }
    test::Hook end() override {
        source_.finish();
        return test::Hook::kDone;
    }
    void pass_time() override {}
    int held_back() const override { return 0; }

private:
    ScriptedSource<Base, Sample> source_;
    std::int64_t stamp_ns_ = 0;
    bool broken_ = false;
};

TEST_CASE("scripted sources keep the contract of their ports", "[port_conformance]") {
    test::check_source_conformance<test::ImuHarness>(
        [] { return std::make_unique<ScriptedHarness<ImuSource, ImuSample>>(); });
    test::check_source_conformance<test::TriggerHarness>(
        [] { return std::make_unique<ScriptedHarness<TriggerSource, TriggerEdge>>(); });
    test::check_source_conformance<test::StereoHarness>(
        [] { return std::make_unique<ScriptedHarness<StereoSource, StereoFrame>>(); });
}

TEST_CASE("a scripted source discards stamps that do not increase") {
    ScriptedImu source;
    REQUIRE(ok(source.start()));
    for (const std::int64_t ns : {5, 5, 3, 6}) {
        source.add({{ns}, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
    }
    ImuSample sample;
    CHECK(source.next({}, sample) == Status::kOk);
    CHECK(source.next({}, sample) == Status::kOk);
    CHECK(sample.stamp.ns == 6);
    CHECK(source.counters().discarded == 2);
}

TEST_CASE("a manual clock moves when slept on and keeps the wall clock's offset") {
    ManualClock clock({100}, {1000});
    clock.sleep({50});
    CHECK(clock.now().ns == 150);
    clock.sleep_until({10});
    CHECK(clock.now().ns == 150);
    clock.set_realtime_offset({7});
    CHECK(clock.read_pair().realtime.ns == 157);
}

}  // namespace
}  // namespace facet::scripted_source_test
