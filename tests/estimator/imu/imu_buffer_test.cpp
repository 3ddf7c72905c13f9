// SPDX-License-Identifier: BSD-2-Clause
// The inertial history: checks on entry, exact interpolation, integration between any stamps, gaps, clipping, and what
// happens when it is full.
#include "estimator/imu/imu_buffer.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "tests/estimator/imu/ramp_history.h"

namespace facet::imu_buffer_test {
namespace {

using test::filled;
using test::kStep_ns;
using test::ms;
using test::ramp;

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
    REQUIRE(ok(buffer->for_each_step(ms(7.3), ms(41.9),
                                     [&](const ImuSample& a, const ImuSample& b, const ImuStepQuality& quality) {
                                         CHECK(a.stamp == at);
                                         CHECK(b.stamp > a.stamp);
                                         CHECK(quality.gap == Duration{});
                                         CHECK(quality.clipped == 0);
                                         CHECK((a.w_B - ramp(a.stamp.ns).w_B).norm() < 1e-14);
                                         at = b.stamp;
                                         ++steps;
                                     })));
    CHECK(at == ms(41.9));
    CHECK(steps == 8);  // 7.3 | 10 15 20 25 30 35 40 | 41.9
    // both ends on samples, both ends within one step, and no length at all
    const auto count = [&](double t0, double t1) {
        int n = 0;
        REQUIRE(ok(buffer->for_each_step(ms(t0), ms(t1),
                                         [&](const ImuSample&, const ImuSample&, const ImuStepQuality&) { ++n; })));
        return n;
    };
    CHECK(count(5, 20) == 3);
    CHECK(count(6, 7) == 1);
    CHECK(count(0, 95) == 19);
    CHECK(count(95, 95) == 0);
    const auto ignore = [](const ImuSample&, const ImuSample&, const ImuStepQuality&) {};
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
    ImuSpan span;
    span.has_gap = true;
    REQUIRE(ok(buffer->integrate_between(ms(12.3), ms(26.1), noise, pre, &span)));
    CHECK_FALSE(span.has_gap);
    CHECK(span.clipped == 0);
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
        ImuSpan span;
        REQUIRE(ok(buffer->integrate_between(ms(t0), ms(t1), noise, pre, &span)));
        return span.has_gap;
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
    ImuSpan span;
    REQUIRE(ok(buffer->integrate_between(Timestamp{wrap_ns - 7'000'000}, Timestamp{wrap_ns + 7'000'000}, ImuNoise{},
                                         pre, &span)));
    CHECK_FALSE(span.has_gap);
    CHECK(pre.dt_s() == Approx(0.014).epsilon(1e-12));
}

TEST_CASE("an axis is clipped from 90 % of its range on, at both ends") {
    ImuLimits limits;
    limits.gyro_range_rad_per_s = 10.0;
    limits.accel_range_m_per_s2 = 100.0;
    const auto clipped = [&](double gyro_z, double accel_x) {
        const auto buffer = std::make_unique<ImuBuffer>(200.0, limits);
        for (int k = 0; k < 5; ++k) {
            ImuSample s = ramp(k * kStep_ns);
            s.w_B.z() = k == 2 ? gyro_z : s.w_B.z();
            s.a_B.x() = k == 2 ? accel_x : s.a_B.x();
            REQUIRE(ok(buffer->push(s)));
        }
        CHECK(buffer->counters().accepted == 5);
        const ImuBufferCounters& c = buffer->counters();
        return std::array<int, 2>{static_cast<int>(c.clipped_gyro), static_cast<int>(c.clipped_accel)};
    };
    CHECK(clipped(8.99, -89.9) == std::array<int, 2>{0, 0});
    CHECK(clipped(9.0, -89.9) == std::array<int, 2>{1, 0});
    CHECK(clipped(-9.0, 90.0) == std::array<int, 2>{1, 1});
    CHECK(clipped(-50.0, -1e4) == std::array<int, 2>{1, 1});
}

TEST_CASE("of a corrected sample the axes count that were clipped as read") {
    auto buffer = std::make_unique<ImuBuffer>();
    const ImuLimits limits;
    const double beyond = 1.2 * limits.accel_range_m_per_s2;
    CHECK(ok(buffer->push({{5'000'000}, {}, {beyond, 0.0, 9.8}}, 0)));
    CHECK(buffer->counters().clipped_accel == 0);
    CHECK(ok(buffer->push({{10'000'000}, {}, {0.5 * beyond, 0.0, 9.8}}, 0x08)));
    CHECK(buffer->counters().clipped_accel == 1);
    CHECK(ok(buffer->push({{15'000'000}, {}, {beyond, 0.0, 9.8}})));
    CHECK(buffer->counters().clipped_accel == 2);
}

TEST_CASE("a clipped axis is bridged between its good neighbours, the others are kept") {
    // GIVEN a linear signal whose forces along x read full scale for three samples
    const ImuLimits limits;
    const auto spiked = [&](double reading) {
        auto buffer = std::make_unique<ImuBuffer>(200.0, limits);
        for (int k = 0; k < 40; ++k) {
            ImuSample s = ramp(k * kStep_ns);
            s.a_B.x() = k >= 18 && k < 21 ? reading : s.a_B.x();
            REQUIRE(ok(buffer->push(s)));
        }
        return buffer;
    };
    const auto buffer = spiked(limits.accel_range_m_per_s2);
    for (int k = 0; k < 40; ++k) {
        CHECK((buffer->sample(k).a_B - ramp(k * kStep_ns).a_B).norm() < 1e-13);
    }
    CHECK(buffer->counters().clipped_accel == 3);
    CHECK(buffer->counters().clipped_gyro == 0);
    // THEN the deltas are the line's, and only x knows less of its velocity: 1.5 ranges over four periods
    const ImuNoise noise;
    Preintegration bridged;
    Preintegration clean;
    ImuSpan span;
    REQUIRE(ok(buffer->integrate_between(ms(50), ms(150), noise, bridged, &span)));
    REQUIRE(ok(filled(40)->integrate_between(ms(50), ms(150), noise, clean)));
    CHECK((span.clipped & kAccelAxes) != 0);
    CHECK((span.clipped & kGyroAxes) == 0);
    CHECK_FALSE(span.has_gap);
    CHECK((bridged.delta_v() - clean.delta_v()).norm() < 1e-12);
    CHECK((bridged.delta_p() - clean.delta_p()).norm() < 1e-12);
    const auto sigma = [](const Preintegration& pre, int row) { return std::sqrt(pre.covariance()(row, row)); };
    CHECK(sigma(bridged, kVel) == Approx((1.5 * limits.accel_range_m_per_s2 - 1.0) * 0.020).epsilon(0.02));
    CHECK(sigma(bridged, kVel + 2) < 0.05);  // turned into by the body's rotation only
    CHECK((bridged.covariance() - clean.covariance()).topLeftCorner<3, 3>().norm() < 1e-18);
    // and intervals beside the run do not know of it
    REQUIRE(ok(buffer->integrate_between(ms(0), ms(85), noise, clean, &span)));
    CHECK(span.clipped == 0);
    REQUIRE(ok(buffer->integrate_between(ms(105), ms(150), noise, clean, &span)));
    CHECK(span.clipped == 0);
    REQUIRE(ok(buffer->integrate_between(ms(87), ms(88), noise, clean, &span)));
    CHECK(span.clipped == 0x08);
    // whatever the reading was beyond the range
    CHECK((spiked(-1e5)->sample(19).a_B - buffer->sample(19).a_B).norm() < 1e-12);
}

TEST_CASE("a true shock beyond the range is within the noise of its bridge") {
    // GIVEN half sines of 1.2 to 4 ranges and 10 to 40 ms on a resting IMU, at random phases of the sampling
    const ImuLimits limits;
    const ImuNoise noise;
    std::mt19937 rng(3);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    double sum_squares = 0.0;
    double worst = 0.0;
    constexpr int kRuns = 300;
    int counted = 0;
    for (int run = 0; run < kRuns; ++run) {
        const double peak = (1.2 + 2.8 * uniform(rng)) * limits.accel_range_m_per_s2 * (run % 2 == 0 ? 1.0 : -1.0);
        const double width_s = 0.01 + 0.03 * uniform(rng);
        const double begin_s = 0.1 + 0.005 * uniform(rng);
        const auto buffer = std::make_unique<ImuBuffer>(200.0, limits);
        for (int k = 0; k < 60; ++k) {
            const double phase = (0.005 * k - begin_s) / width_s;
            const double shock = phase > 0.0 && phase < 1.0 ? peak * std::sin(M_PI * phase) : 0.0;
            const double range = limits.accel_range_m_per_s2;
            REQUIRE(ok(
                buffer->push({ms(5.0 * k), Eigen::Vector3d::Zero(), {0.0, std::clamp(shock, -range, range), 9.81}})));
        }
        if (buffer->counters().clipped_accel == 0) {
            continue;
        }
        Preintegration pre;
        REQUIRE(ok(buffer->integrate_between(ms(0), ms(295), noise, pre)));
        const double error = pre.delta_v().y() - peak * width_s * 2.0 / M_PI;
        const double ratio = error / std::sqrt(pre.covariance()(kVel + 1, kVel + 1));
        sum_squares += ratio * ratio;
        worst = std::max(worst, std::abs(ratio));
        ++counted;
    }
    // THEN the errors are of the size that is said: one-sided, so their mean is not zero
    REQUIRE(counted > kRuns / 2);
    CHECK(worst < 3.0);
    CHECK(sum_squares / counted < 1.5);
    CHECK(sum_squares / counted > 0.3);
}

TEST_CASE("while a run of clipped samples lasts the last good one holds, afterwards the bridge") {
    const ImuLimits limits;
    const ImuNoise noise;
    const auto buffer = filled(20);
    const ImuSample good = ramp(19 * kStep_ns);
    double sigma = 0.0;
    for (int k = 20; k < 26; ++k) {
        ImuSample s = ramp(k * kStep_ns);
        s.w_B.y() = -limits.gyro_range_rad_per_s;
        REQUIRE(ok(buffer->push(s)));
        CHECK(buffer->sample(k).w_B.y() == good.w_B.y());
        CHECK(buffer->sample(k).w_B.x() == s.w_B.x());
        Preintegration pre;
        ImuSpan span;
        REQUIRE(ok(buffer->integrate_between(ms(95), buffer->newest(), noise, pre, &span)));
        CHECK((span.clipped & kGyroAxes) != 0);
        const double grown = std::sqrt(pre.covariance()(kTheta + 1, kTheta + 1));
        CHECK(grown == Approx(1.5 * limits.gyro_range_rad_per_s * 0.005 * (k - 19)).epsilon(0.05));
        CHECK(grown > sigma);
        sigma = grown;
    }
    REQUIRE(ok(buffer->push(ramp(26 * kStep_ns))));
    for (int k = 20; k < 26; ++k) {
        CHECK(buffer->sample(k).w_B.y() == Approx(ramp(k * kStep_ns).w_B.y()).epsilon(1e-12));
    }
    Eigen::Quaterniond bridged;
    Eigen::Quaterniond clean;
    REQUIRE(ok(buffer->rotation_between(ms(80), ms(130), Eigen::Vector3d::Zero(), bridged)));
    REQUIRE(ok(filled(30)->rotation_between(ms(80), ms(130), Eigen::Vector3d::Zero(), clean)));
    CHECK(bridged.angularDistance(clean) < 1e-12);
}

TEST_CASE("runs without a good sample before them, and longer than the ring") {
    const double range = ImuLimits{}.accel_range_m_per_s2;
    const ImuNoise noise;
    const auto push = [&](ImuBuffer& buffer, int k, bool is_clipped) {
        ImuSample s = ramp(k * kStep_ns);
        s.a_B.z() = is_clipped ? range : s.a_B.z();
        REQUIRE(ok(buffer.push(s)));
    };
    // clipped from the first sample on: the reading until a good one comes, then that
    const auto buffer = filled(0);
    push(*buffer, 0, true);
    push(*buffer, 1, true);
    CHECK(buffer->sample(0).a_B.z() == range);
    Preintegration pre;
    REQUIRE(ok(buffer->integrate_between(ms(0), ms(5), noise, pre)));
    CHECK(pre.covariance()(kVel + 2, kVel + 2) > 0.01);
    push(*buffer, 2, false);
    CHECK(buffer->sample(0).a_B.z() == 9.81);
    CHECK(buffer->sample(1).a_B.z() == 9.81);
    // longer than the ring
    const auto full = filled(1);
    for (int k = 1; k < kMaxImuSamples + 10; ++k) {
        push(*full, k, true);
    }
    push(*full, kMaxImuSamples + 10, false);
    CHECK(full->size() == kMaxImuSamples);
    CHECK(full->counters().clipped_accel == kMaxImuSamples + 9);
    CHECK(full->sample(0).a_B.z() == 9.81);
    REQUIRE(ok(full->integrate_between(full->oldest(), full->newest(), noise, pre)));
    CHECK(pre.covariance().allFinite());
}

TEST_CASE("counts of samples go on beyond 32 bits: three weeks at 2 kHz") {
    ImuBufferCounters counters;
    counters.accepted = counters.overwritten = 0xffffffffU;
    ++counters.accepted;
    CHECK(counters.accepted > counters.overwritten);
    counters.gaps = counters.out_of_order = counters.clipped_gyro = 0xffffffffU;
    ++counters.gaps;
    counters.not_finite = counters.clipped_accel = 2;
    Health health;
    counters.report(health);
    CHECK(health.imu_gaps == 0x100000000U);
    CHECK(health.imu_dropped == 0x100000001U);
    CHECK(health.imu_clipped == 0x100000001U);
}

}  // namespace facet::imu_buffer_test
