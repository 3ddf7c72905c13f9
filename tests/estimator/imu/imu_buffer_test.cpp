// SPDX-License-Identifier: BSD-2-Clause
// The inertial history: checks on entry, exact interpolation, integration between arbitrary stamps, gaps, full buffer.
#include "estimator/imu/imu_buffer.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>

namespace facet {
namespace {

constexpr std::int64_t kStep_ns = 5'000'000;

/// Linear in time, so that interpolation and the mean over a step are exact.
ImuSample ramp(std::int64_t stamp_ns) {
    const double t = static_cast<double>(stamp_ns) * 1e-9;
    return {Timestamp{stamp_ns}, {0.5 * t, 0.2 - t, 0.3}, {1.0 + t, -2.0 * t, 9.81}};
}

/// On the heap: the buffer is too large for a local.
std::unique_ptr<ImuBuffer> filled(int samples, std::int64_t first_ns = 0) {
    auto buffer = std::make_unique<ImuBuffer>(200.0);
    for (int k = 0; k < samples; ++k) {
        REQUIRE(ok(buffer->push(ramp(first_ns + k * kStep_ns))));
    }
    return buffer;
}

Timestamp ms(double t) { return Timestamp{static_cast<std::int64_t>(t * 1e6)}; }

}  // namespace

TEST_CASE("an empty buffer is not ready") {
    const auto buffer = filled(0);
    ImuSample s;
    Preintegration pre;
    Eigen::Quaterniond q;
    CHECK(buffer->empty());
    CHECK(buffer->interpolate(ms(1), s) == Status::kNotReady);
    CHECK(buffer->integrate_between(ms(0), ms(1), ImuNoise{}, pre) == Status::kNotReady);
    CHECK(buffer->rotation_between(ms(0), ms(1), Eigen::Vector3d::Zero(), q) == Status::kNotReady);
}

TEST_CASE("duplicates, stamps out of order and numbers that are not finite are refused and counted") {
    const auto buffer = filled(3);
    CHECK(buffer->push(ramp(2 * kStep_ns)) == Status::kOutOfOrder);
    CHECK(buffer->push(ramp(kStep_ns)) == Status::kOutOfOrder);
    ImuSample bad = ramp(3 * kStep_ns);
    bad.w_B.y() = std::nan("");
    CHECK(buffer->push(bad) == Status::kInvalidArgument);
    bad = ramp(3 * kStep_ns);
    bad.a_B.z() = std::numeric_limits<double>::infinity();
    CHECK(buffer->push(bad) == Status::kInvalidArgument);
    CHECK(buffer->size() == 3);
    CHECK(ok(buffer->push(ramp(3 * kStep_ns))));
    CHECK(buffer->counters().accepted == 4);
    CHECK(buffer->counters().out_of_order == 2);
    CHECK(buffer->counters().not_finite == 2);
    CHECK(buffer->counters().gaps == 0);
    buffer->clear(100.0);
    CHECK(buffer->empty());
    CHECK(buffer->counters().accepted == 0);
}

TEST_CASE("interpolation is exact on a linear signal, and bounded by oldest and newest") {
    const auto buffer = filled(10, 1'000'000);
    for (const std::int64_t t : {1'000'000LL, 1'000'001LL, 3'333'333LL, 6'000'000LL, 45'999'999LL, 46'000'000LL}) {
        CAPTURE(t);
        ImuSample s;
        REQUIRE(ok(buffer->interpolate(Timestamp{t}, s)));
        CHECK(s.stamp.ns == t);
        CHECK((s.w_B - ramp(t).w_B).norm() < 1e-14);
        CHECK((s.a_B - ramp(t).a_B).norm() < 1e-14);
    }
    ImuSample s;
    s.stamp.ns = -5;
    CHECK(buffer->interpolate(Timestamp{999'999}, s) == Status::kNotFound);
    CHECK(buffer->interpolate(Timestamp{46'000'001}, s) == Status::kNotReady);
    CHECK(s.stamp.ns == -5);
}

TEST_CASE("steps tile the interval exactly") {
    const auto buffer = filled(20);
    Timestamp at = ms(7.3);
    int steps = 0;
    REQUIRE(ok(buffer->for_each_step(ms(7.3), ms(41.9), [&](const ImuSample& a, const ImuSample& b, Duration gap) {
        CHECK(a.stamp == at);
        CHECK(b.stamp > a.stamp);
        CHECK(gap == Duration{});
        CHECK((a.w_B - ramp(a.stamp.ns).w_B).norm() < 1e-14);
        at = b.stamp;
        ++steps;
    })));
    CHECK(at == ms(41.9));
    CHECK(steps == 8);  // 7.3 | 10 15 20 25 30 35 40 | 41.9
    // both ends on samples, both ends within one step, and no length at all
    const auto count = [&](double t0, double t1) {
        int n = 0;
        REQUIRE(ok(buffer->for_each_step(ms(t0), ms(t1), [&](const ImuSample&, const ImuSample&, Duration) { ++n; })));
        return n;
    };
    CHECK(count(5, 20) == 3);
    CHECK(count(6, 7) == 1);
    CHECK(count(0, 95) == 19);
    CHECK(count(95, 95) == 0);
    const auto ignore = [](const ImuSample&, const ImuSample&, Duration) {};
    CHECK(buffer->for_each_step(ms(20), ms(10), ignore) == Status::kInvalidArgument);
    CHECK(buffer->for_each_step(ms(10), ms(95.1), ignore) == Status::kNotReady);
    CHECK(buffer->for_each_step(ms(-1), ms(10), ignore) == Status::kNotFound);
}

TEST_CASE("integration between stamps equals integration of the interpolated samples by hand") {
    const auto buffer = filled(20);
    ImuBias bias;
    bias.gyro = {0.01, 0.02, -0.01};
    bias.accel = {0.1, 0.0, -0.1};
    const ImuNoise noise;
    Preintegration expected(bias);
    const std::int64_t stamps[] = {12'300'000, 15'000'000, 20'000'000, 25'000'000, 26'100'000};
    for (int k = 0; k < 4; ++k) {
        REQUIRE(ok(expected.integrate(ramp(stamps[k]), ramp(stamps[k + 1]), noise)));
    }
    Preintegration pre(bias);
    bool has_gap = true;
    REQUIRE(ok(buffer->integrate_between(ms(12.3), ms(26.1), noise, pre, &has_gap)));
    CHECK_FALSE(has_gap);
    CHECK(pre.dt_s() == Approx(13.8e-3).epsilon(1e-12));
    CHECK((pre.delta_p() - expected.delta_p()).norm() < 1e-15);
    CHECK((pre.delta_v() - expected.delta_v()).norm() < 1e-15);
    CHECK(pre.delta_q().angularDistance(expected.delta_q()) < 1e-14);
    CHECK((pre.covariance() - expected.covariance()).norm() < 1e-18);

    Eigen::Quaterniond q;
    REQUIRE(ok(buffer->rotation_between(ms(12.3), ms(26.1), bias.gyro, q)));
    CHECK(q.angularDistance(expected.delta_q()) < 1e-14);

    // on failure the sums are untouched
    CHECK(buffer->integrate_between(ms(26.1), ms(500), noise, pre) == Status::kNotReady);
    CHECK(pre.dt_s() == Approx(13.8e-3).epsilon(1e-12));
}

TEST_CASE("two intervals with a common bound add up to the whole") {
    const auto buffer = filled(60);
    const ImuNoise noise;
    Preintegration whole;
    Preintegration parts;
    REQUIRE(ok(buffer->integrate_between(ms(3), ms(280), noise, whole)));
    REQUIRE(ok(buffer->integrate_between(ms(3), ms(111.7), noise, parts)));
    REQUIRE(ok(buffer->integrate_between(ms(111.7), ms(280), noise, parts)));
    CHECK(whole.dt_s() == Approx(parts.dt_s()).epsilon(1e-12));
    CHECK((whole.delta_p() - parts.delta_p()).norm() < 1e-7);
    CHECK(whole.delta_q().angularDistance(parts.delta_q()) < 1e-7);
}

TEST_CASE("gaps are counted, reported for the intervals they touch only, and bridged with honest noise") {
    // GIVEN 20 samples, 100 ms without any, and 20 more
    const auto buffer = filled(20);
    for (int k = 0; k < 20; ++k) {
        REQUIRE(ok(buffer->push(ramp(19 * kStep_ns + 100'000'000 + k * kStep_ns))));
    }
    CHECK(buffer->counters().gaps == 1);
    const ImuNoise noise;
    const auto gap_in = [&](double t0, double t1) {
        Preintegration pre;
        bool has_gap = false;
        REQUIRE(ok(buffer->integrate_between(ms(t0), ms(t1), noise, pre, &has_gap)));
        return has_gap;
    };
    // THEN only intervals inside or across see it
    CHECK_FALSE(gap_in(10, 95));
    CHECK(gap_in(10, 96));
    CHECK(gap_in(120, 130));
    CHECK(gap_in(190, 230));
    CHECK_FALSE(gap_in(195, 230));
    // and the bridged deltas are those of the line between its ends, finely sampled: 200 Hz, as a whole buffer's
    Preintegration bridged;
    Preintegration complete;
    REQUIRE(ok(buffer->integrate_between(ms(50), ms(250), noise, bridged)));
    REQUIRE(ok(filled(60)->integrate_between(ms(50), ms(250), noise, complete)));
    CHECK((bridged.delta_p() - complete.delta_p()).norm() < 1e-12);
    CHECK((bridged.delta_v() - complete.delta_v()).norm() < 1e-12);
    CHECK(bridged.delta_q().angularDistance(complete.delta_q()) < 1e-12);
    // with the rotation's deviation about 0.1 rad/s times 0.1 s
    const double theta_sigma = std::sqrt(bridged.covariance()(kTheta, kTheta));
    CHECK(theta_sigma == Approx(0.01).epsilon(0.1));
    CHECK(std::sqrt(complete.covariance()(kTheta, kTheta)) < 1e-3);
}

TEST_CASE("one or two lost samples are no gap") {
    const auto buffer = filled(3);
    REQUIRE(ok(buffer->push(ramp(5 * kStep_ns))));
    REQUIRE(ok(buffer->push(ramp(8 * kStep_ns))));
    CHECK(buffer->counters().gaps == 0);
    REQUIRE(ok(buffer->push(ramp(12 * kStep_ns))));
    CHECK(buffer->counters().gaps == 1);
}

TEST_CASE("a full buffer drops the oldest and goes on") {
    constexpr int kExtra = 100;
    const auto buffer = filled(kMaxImuSamples + kExtra);
    CHECK(buffer->size() == kMaxImuSamples);
    CHECK(buffer->counters().overwritten == kExtra);
    CHECK(buffer->oldest().ns == kExtra * kStep_ns);
    CHECK(buffer->newest().ns == (kMaxImuSamples + kExtra - 1) * kStep_ns);
    ImuSample s;
    CHECK(buffer->interpolate(Timestamp{(kExtra - 1) * kStep_ns}, s) == Status::kNotFound);
    // across the place where the ring wraps
    const std::int64_t wrap_ns = kMaxImuSamples * kStep_ns;
    Preintegration pre;
    bool has_gap = false;
    REQUIRE(ok(buffer->integrate_between(Timestamp{wrap_ns - 7'000'000}, Timestamp{wrap_ns + 7'000'000}, ImuNoise{},
                                         pre, &has_gap)));
    CHECK_FALSE(has_gap);
    CHECK(pre.dt_s() == Approx(0.014).epsilon(1e-12));
}

TEST_CASE("drop_before keeps what interpolation at its stamp needs") {
    const auto buffer = filled(20);
    buffer->drop_before(ms(-5));
    CHECK(buffer->size() == 20);
    buffer->drop_before(ms(32));
    CHECK(buffer->oldest() == ms(30));
    ImuSample s;
    CHECK(ok(buffer->interpolate(ms(32), s)));
    buffer->drop_before(ms(40));
    CHECK(buffer->oldest() == ms(40));
    buffer->drop_before(ms(1000));
    CHECK(buffer->size() == 1);
    CHECK(buffer->newest() == ms(95));
    CHECK(ok(buffer->push(ramp(100'000'000))));
    CHECK(ok(buffer->interpolate(ms(97), s)));
}

}  // namespace facet
