// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/pairing_proof.h"

#include <catch2/catch.hpp>

#include "tests/support/scripted_source.h"

namespace facet::pairing_proof_test {
namespace {

constexpr Duration kPeriod = Duration::from_seconds(0.05);

/// Pulses on a grid, of which one can be left out; they are seen `delay` later.
class Pulses {
public:
    explicit Pulses(ManualClock& clock) : clock_(clock) {}
    void leave_out_next() { left_out_ = clock_.now().ns / kPeriod.ns + 1; }
    bool is_made(std::int64_t n) const { return n != left_out_; }

private:
    ManualClock& clock_;
    std::int64_t left_out_ = -1;
};

/// What of a device counts here: its stamps.
template <class Base, class Sample>
class Follower final : public Base {
public:
    Follower(ManualClock& clock, const Pulses& pulses, double delay_s, bool follows = true)
        : clock_(clock), pulses_(pulses), delay_(Duration::from_seconds(delay_s)), follows_(follows) {}
    Status start() override { return Status::kOk; }
    void stop() override {}
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return {}; }
    std::string_view problem() const override { return ""; }
    Status next(Duration timeout, Sample& sample) override {
        while (follows_ && !pulses_.is_made(next_)) {
            ++next_;
        }
        const Timestamp due = Timestamp{next_ * kPeriod.ns} + delay_;
        if (due > clock_.now()) {
            clock_.advance(timeout);
            return Status::kNotReady;
        }
        ++next_;
        sample.stamp = due;
        return Status::kOk;
    }

private:
    ManualClock& clock_;
    const Pulses& pulses_;
    Duration delay_;
    bool follows_;
    std::int64_t next_ = 1;
};

using Edges = Follower<TriggerSource, TriggerEdge>;
using Camera = Follower<CameraSource, CameraFrame>;

TEST_CASE("a pulse that is left out shows how late frames are stamped, whole periods included") {
    for (const double lag_s : {0.004, 0.054, 0.104}) {
        ManualClock clock;
        Pulses pulses(clock);
        Edges edges(clock, pulses, 0.0);
        Camera left(clock, pulses, lag_s);
        Camera right(clock, pulses, lag_s + 0.001);
        const PairingProof proof = prove_pairing({&edges, &left, &right}, clock, Duration::from_seconds(1.5),
                                                 [&] { pulses.leave_out_next(); });
        REQUIRE(only_gap(proof.edges, kPeriod));
        CHECK(proof.lag(proof.left, kPeriod) == Duration::from_seconds(lag_s));
        CHECK(proof.lag(proof.right, kPeriod) == Duration::from_seconds(lag_s + 0.001));
    }
}

TEST_CASE("a camera that runs freely shows no gap") {
    ManualClock clock;
    Pulses pulses(clock);
    Edges edges(clock, pulses, 0.0);
    Camera free_running(clock, pulses, 0.02, false);
    const PairingProof proof = prove_pairing({&edges, &free_running, nullptr}, clock, Duration::from_seconds(1.5),
                                             [&] { pulses.leave_out_next(); });
    CHECK(only_gap(proof.edges, kPeriod));
    CHECK(proof.left.size() > 20);
    CHECK(proof.right.empty());
    CHECK_FALSE(proof.lag(proof.left, kPeriod));
}

TEST_CASE("one gap is a proof, two are none") {
    const auto stamps = [](std::initializer_list<int> ms) {
        std::vector<Timestamp> result;
        for (const int t : ms) {
            result.push_back({t * 1'000'000LL});
        }
        return result;
    };
    CHECK(only_gap(stamps({0, 50, 150, 200}), kPeriod) == 2);
    CHECK_FALSE(only_gap(stamps({0, 50, 100}), kPeriod));
    CHECK_FALSE(only_gap(stamps({0, 100, 150, 250}), kPeriod));
    CHECK_FALSE(only_gap({}, kPeriod));
}

}  // namespace
}  // namespace facet::pairing_proof_test
