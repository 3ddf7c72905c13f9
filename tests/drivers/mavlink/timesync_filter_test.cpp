// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/timesync_filter.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace facet::timesync_filter_test {
namespace {

/// Another machine's clock, and a link to it.
struct Remote {
    double offset_s = -81'234.567;
    double drift = 40e-6;
    double jitter_s = 0.0;
    double base_s = 0.0004;  ///< least delay, each way
    std::mt19937 random{7};

    Timestamp at(Timestamp own) const { return own + Duration::from_seconds(offset_s + drift * own.seconds()); }
    double delay() { return base_s + jitter_s * std::uniform_real_distribution<double>(0.0, 1.0)(random); }

    Status exchange(TimesyncFilter& filter, Timestamp sent) {
        const Timestamp there = sent + Duration::from_seconds(delay());
        const Timestamp back = there + Duration::from_seconds(delay());
        return filter.add(sent, back, at(there));
    }
    double error_s(const TimesyncFilter& filter, Timestamp own) const {
        return (filter.to_remote(own) - at(own)).seconds();
    }
};

TEST_CASE("delays of 0 to 20 ms on each way: the offset is known to 1 ms within half a minute, and the filter knows") {
    int claimed = 0;
    constexpr int kRuns = 200;
    for (unsigned seed = 1; seed <= kRuns; ++seed) {
        Remote remote{.jitter_s = 0.02, .random = std::mt19937(seed)};
        TimesyncFilter filter;
        Timestamp t{5'000'000'000};
        const auto exchange = [&] {
            REQUIRE(remote.exchange(filter, t) == Status::kOk);
            t = t + Duration::from_seconds(0.1);
        };
        while (!filter.ready() && t.ns < 35'000'000'000) {
            exchange();
        }
        INFO(seed);
        REQUIRE(filter.ready());
        CHECK(std::abs(remote.error_s(filter, t)) < 1e-3);
        for (int i = 0; i < 300; ++i) {
            exchange();
        }
        const double error_s = std::abs(remote.error_s(filter, t));
        CHECK(error_s < 1e-3);
        claimed += error_s < 2.0 * filter.sigma_s() ? 1 : 0;
    }
    CHECK(claimed > 0.9 * kRuns);
}

TEST_CASE("a quick link is known to a fraction of a millisecond after one block, and then the drift") {
    Remote remote{.jitter_s = 0.0002};
    TimesyncFilter filter;
    Timestamp t;
    for (std::size_t i = 0; i < TimesyncFilter::kBlock; ++i) {
        CHECK_FALSE(filter.ready());
        REQUIRE(remote.exchange(filter, t) == Status::kOk);
        t = t + Duration::from_seconds(0.1);
    }
    REQUIRE(filter.ready());
    CHECK(std::abs(remote.error_s(filter, t)) < 0.3e-3);
    for (int i = 0; i < 1'000; ++i) {
        REQUIRE(remote.exchange(filter, t) == Status::kOk);
        t = t + Duration::from_seconds(0.1);
    }
    CHECK(filter.drift() == Approx(40e-6).margin(2e-6));
    CHECK(std::abs(remote.error_s(filter, t)) < 0.05e-3);
}

TEST_CASE("a clock that steps is followed after five answers, and single liars are not") {
    Remote remote{.jitter_s = 0.002};
    TimesyncFilter filter;
    std::int64_t t = 0;
    const auto exchange = [&] { return remote.exchange(filter, {t += 100'000'000}); };
    for (int i = 0; i < 100; ++i) {
        REQUIRE(exchange() == Status::kOk);
    }
    REQUIRE(filter.ready());
    remote.offset_s += 3.0;
    CHECK(exchange() == Status::kCorrupt);
    CHECK(filter.ready());
    remote.offset_s -= 3.0;
    CHECK(exchange() == Status::kOk);
    remote.offset_s = 12.0;  // the flight controller has started anew
    for (int i = 0; i < TimesyncFilter::kForStep; ++i) {
        CHECK(filter.ready());
        CHECK(exchange() == Status::kCorrupt);
    }
    CHECK_FALSE(filter.ready());
    CHECK(filter.steps() == 1);
    for (int i = 0; i < 130; ++i) {
        REQUIRE(exchange() == Status::kOk);
    }
    REQUIRE(filter.ready());
    CHECK(std::abs(remote.error_s(filter, {t})) < 1e-3);
}

TEST_CASE("a step within the first block restarts") {
    Remote remote;
    TimesyncFilter filter;
    std::int64_t t = 0;
    for (int i = 0; i < 30; ++i) {
        (void)remote.exchange(filter, {t += 100'000'000});
    }
    remote.offset_s += 0.5;
    for (int i = 0; i < 34; ++i) {
        (void)remote.exchange(filter, {t += 100'000'000});
    }
    CHECK(filter.steps() == 1);
    CHECK_FALSE(filter.ready());
}

TEST_CASE("round trips that are none, or too long, are refused") {
    TimesyncFilter filter;
    CHECK(filter.add({2'000'000}, {1'000'000}, {5}) == Status::kInvalidArgument);
    CHECK(filter.add({0}, {600'000'000}, {5}) == Status::kInvalidArgument);
    CHECK(filter.add({0}, {1'000'000}, {5}) == Status::kOk);
    CHECK(filter.add({0}, {1'000'000}, {5}) == Status::kInvalidArgument);  // not after the one before
}

}  // namespace
}  // namespace facet::timesync_filter_test
