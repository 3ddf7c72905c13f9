// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/sync/clock_map.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

namespace facet::clock_map_test {
namespace {

constexpr std::int64_t kEpochNs = 1'700'000'000'000'000'000;

/// The true host time of a source stamp.
struct TrueClock {
    double drift = 0.0;
    std::int64_t offset_ns = kEpochNs;
    Timestamp host(Timestamp source) const {
        return {source.ns + offset_ns + std::llround(drift * static_cast<double>(source.ns))};
    }
};

double worst_error_s(const ClockMap& map, const TrueClock& truth, std::int64_t from_ns, std::int64_t to_ns) {
    double worst = 0.0;
    for (std::int64_t t = from_ns; t <= to_ns; t += (to_ns - from_ns) / 20 + 1) {
        worst = std::max(worst, std::abs((map.to_host({t}) - truth.host({t})).seconds()));
    }
    return worst;
}

TEST_CASE("offset and drift of two clocks read together are found to microseconds") {
    std::mt19937 random(1);  // NOLINT(cert-msc51-cpp): fixed on purpose
    std::normal_distribution<double> noise(0.0, 20e-6);
    for (const double drift : {0.0, 50e-6, -80e-6}) {
        const TrueClock truth{drift, kEpochNs};
        ClockMap map;
        std::int64_t t = 1'000'000'000;
        for (int i = 0; i < 200; ++i, t += 500'000'000) {
            CHECK(map.add({t}, truth.host({t}) + Duration::from_seconds(noise(random))) == Status::kOk);
        }
        CHECK(worst_error_s(map, truth, t - 500'000'000, t + 500'000'000) < 15e-6);
        CHECK(std::abs(map.drift() - drift) < 3e-6);
    }
}

TEST_CASE("late arrivals: the earliest count, and the delay's mean does not come in") {
    // Delays of at least 100 us, 2 ms on average, sometimes much longer.
    std::mt19937 random(2);  // NOLINT(cert-msc51-cpp): fixed on purpose
    std::exponential_distribution<double> delay(1.0 / 2e-3);
    ClockMapOptions options;
    options.one_sided = true;
    options.pair_sigma_s = 100e-6;
    const TrueClock truth{30e-6, kEpochNs};
    ClockMap one_sided(options);
    options.one_sided = false;
    ClockMap symmetric(options);
    std::int64_t t = 0;
    for (int i = 0; i < 4000; ++i) {
        t += 5'000'000;
        const Timestamp host = truth.host({t}) + Duration::from_seconds(100e-6 + delay(random));
        (void)one_sided.add({t}, host);
        (void)symmetric.add({t}, host);
    }
    CHECK(worst_error_s(one_sided, truth, t - 20'000'000, t) < 0.5e-3);
    CHECK(worst_error_s(symmetric, truth, t - 20'000'000, t) > 1.5e-3);
}

TEST_CASE("a first arrival that is late is not taken for drift, however unsteady the clock may be") {
    ClockMapOptions options;
    options.one_sided = true;
    options.pair_sigma_s = 200e-6;
    options.drift_sigma = 0.02;
    for (const double drift : {-0.01, 0.0, 0.01}) {
        for (const double late_s : {0.0, 2e-3, 8e-3}) {
            const TrueClock truth{drift, kEpochNs};
            ClockMap map(options);
            std::int64_t t = 0;
            for (int i = 0; i < 2000; ++i, t += 5'000'000) {
                const double delay_s = i == 0 ? late_s : 50e-6;
                (void)map.add({t}, truth.host({t}) + Duration::from_seconds(delay_s));
                if (i >= 100) {
                    REQUIRE(worst_error_s(map, truth, t, t + 5'000'000) < 0.5e-3);
                }
            }
            CHECK(map.counters().steps == 0);
            CHECK(std::abs(map.drift() - drift) < 50e-6);
        }
    }
}

TEST_CASE("arrivals that begin late, or are late for long, are not taken for drift") {
    // Delays of 2 ms on average, those above 10 ms outliers: twenty sources, a second after each one's start.
    ClockMapOptions options;
    options.one_sided = true;
    options.pair_sigma_s = 200e-6;
    const TrueClock truth{30e-6, kEpochNs};
    for (unsigned seed = 0; seed < 20; ++seed) {
        std::mt19937 random(seed);
        std::exponential_distribution<double> delay(1.0 / 2e-3);
        ClockMap map(options);
        for (std::int64_t t = 0; t < 20'000'000'000; t += 5'000'000) {
            (void)map.add({t}, truth.host({t}) + Duration::from_seconds(delay(random)));
            if (t > 1'000'000'000) {
                REQUIRE(worst_error_s(map, truth, t, t + 5'000'000) < 1e-3);
            }
        }
        CHECK(std::abs(map.drift() - truth.drift) < 20e-6);
    }
}

TEST_CASE("a step of the wall clock is followed within five pairs and counted once; single outliers are not") {
    TrueClock truth{10e-6, kEpochNs};
    ClockMap map;
    std::int64_t t = 0;
    const auto feed = [&](int pairs) {
        for (int i = 0; i < pairs; ++i) {
            t += 100'000'000;
            (void)map.add({t}, truth.host({t}));
        }
    };
    feed(50);
    t += 100'000'000;
    CHECK(map.add({t}, truth.host({t}) + Duration::from_seconds(3.0)) == Status::kCorrupt);
    feed(5);
    CHECK(map.counters().outliers == 1);
    CHECK(map.counters().steps == 0);
    CHECK(worst_error_s(map, truth, t, t + 100'000'000) < 1e-6);
    truth.offset_ns -= 2'000'000'000;
    feed(4);
    CHECK(map.counters().steps == 0);
    feed(1);
    CHECK(map.counters().steps == 1);
    CHECK(worst_error_s(map, truth, t, t + 100'000'000) < 5e-6);
}

TEST_CASE("mapped streams stay in order, whatever the estimate does") {
    std::mt19937 random(3);  // NOLINT(cert-msc51-cpp): fixed on purpose
    std::normal_distribution<double> noise(0.0, 2e-3);
    ClockMapOptions options;
    options.pair_sigma_s = 2e-3;
    options.step = Duration::from_seconds(0.1);
    ClockMap map(options);
    Timestamp mapped;
    CHECK(map.map({0}, {0}, mapped) == Status::kNotReady);
    Timestamp last;
    std::int64_t t = 0;
    int given = 0;
    for (int i = 0; i < 2000; ++i) {
        t += 200'000;
        (void)map.add({t}, Timestamp{t + kEpochNs} + Duration::from_seconds(noise(random)));
        if (ok(map.map({t}, {t + kEpochNs + 1'000'000'000}, mapped))) {
            REQUIRE((given == 0 || mapped > last));
            last = mapped;
            ++given;
        }
    }
    CHECK(given > 1800);
    // What would lie in the future is not given, and does not count as the last one.
    Timestamp untouched{5};
    CHECK(map.map({t + 3'600'000'000'000}, {t + kEpochNs}, untouched) == Status::kCorrupt);
    CHECK(untouched.ns == 5);
    CHECK(ok(map.map({t + 20'000'000}, {t + kEpochNs + 1'000'000'000}, mapped)));
}

TEST_CASE("a source that was reset starts a new epoch") {
    ClockMap map;
    for (std::int64_t t = 1; t <= 10; ++t) {
        (void)map.add({t * 100'000'000}, {t * 100'000'000 + 77});
    }
    CHECK(map.add({500'000'000}, {1'100'000'000}) == Status::kOutOfOrder);
    CHECK(map.counters().steps == 1);
    for (std::int64_t t = 6; t <= 12; ++t) {
        CHECK(map.add({t * 100'000'000}, {t * 100'000'000 + 600'000'000}) == Status::kOk);
    }
    CHECK(std::abs(map.to_host({1'300'000'000}).ns - 1'900'000'000) < 1000);
    CHECK(map.add({1'200'000'000}, {0}) == Status::kOutOfOrder);  // a duplicate
}

}  // namespace
}  // namespace facet::clock_map_test
