// SPDX-License-Identifier: BSD-2-Clause
// Inertial samples that are not believed: replaced by a steady motion, noisier, and restored to the bit afterwards.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/estimator/imu/ramp_history.h"

namespace facet::replaced_readings_test {
namespace {

using test::filled;
using test::kStep_ns;
using test::ms;
using test::ramp;

const SteadyMotion kMotion{{0.0, 0.0, 1.0}, {0.0, 2.0, 9.0}, {{0.01, 0.0, 0.0}, {0.0, 0.1, 0.0}}};

}  // namespace

TEST_CASE("replaced readings are those of a steady motion, of the suspected axes only", "[replaced_readings]") {
    const auto buffer = filled(41);
    buffer->replace(ms(50), ms(100), kGyroAxes, kMotion);
    CHECK(buffer->sample(10).w_B == ramp(10 * kStep_ns).w_B);  // at 50 ms: before
    CHECK(buffer->sample(21).w_B == ramp(21 * kStep_ns).w_B);
    for (int k = 11; k <= 20; ++k) {
        CHECK(buffer->sample(k).w_B == Eigen::Vector3d(0.01, 0.0, 1.0));
        CHECK(buffer->sample(k).a_B == ramp(k * kStep_ns).a_B);
    }
    buffer->replace(ms(50), ms(100), kAccelAxes, kMotion);
    CHECK(buffer->sample(15).w_B == ramp(15 * kStep_ns).w_B);
    // After 25 ms at 1 rad/s gravity has turned by as much, the other way.
    const Eigen::Vector3d turned(2.0 * std::sin(0.025), 2.0 * std::cos(0.025) + 0.1, 9.0);
    CHECK((buffer->sample(15).a_B - turned).norm() < 1e-12);
}

TEST_CASE("replacing raises the noise of the suspected axes, and the span reports it", "[replaced_readings]") {
    const auto buffer = filled(41);
    Preintegration sure;
    Preintegration replaced;
    ImuSpan span;
    REQUIRE(ok(buffer->integrate_between(ms(50), ms(100), ImuNoise{}, sure, &span)));
    CHECK_FALSE(span.is_replaced);
    buffer->set_replacement_noise({Eigen::Vector3d::Constant(0.25), Eigen::Vector3d::Constant(4.0)});
    buffer->replace(ms(50), ms(100), kAccelAxes, kMotion);
    REQUIRE(ok(buffer->integrate_between(ms(50), ms(100), ImuNoise{}, replaced, &span)));
    CHECK(span.is_replaced);
    const Eigen::Matrix<double, 9, 9> more = replaced.covariance() - sure.covariance();
    CHECK(more.topLeftCorner<3, 3>().norm() < 1e-6);
    for (int i = 6; i < 9; ++i) {
        CHECK(more(i, i) == Approx(4.0 * 0.05).epsilon(0.01));  // white noise over 50 ms
    }
    REQUIRE(ok(buffer->integrate_between(ms(105), ms(150), ImuNoise{}, sure, &span)));
    CHECK_FALSE(span.is_replaced);
}

TEST_CASE("the span reports a sensor that hangs, and replaced readings are not learnt from", "[replaced_readings]") {
    const auto buffer = filled(41);
    std::int64_t stamp_ns = 40 * kStep_ns;
    const auto hang = [&](int samples) {
        for (int k = 0; k < samples; ++k) {
            ImuSample sample = ramp(stamp_ns += kStep_ns);
            sample.a_B = {0.0, 1.0, 9.0};
            REQUIRE(ok(buffer->push(sample)));
        }
    };
    const auto stuck = [&](std::int64_t from_ns, std::int64_t to_ns) {
        Preintegration sum;
        ImuSpan span;
        REQUIRE(ok(buffer->integrate_between(Timestamp{from_ns}, Timestamp{to_ns}, ImuNoise{}, sum, &span)));
        return span.stuck;
    };
    hang(41);
    CHECK(stuck(0, 60 * kStep_ns) == 0);
    CHECK(stuck(0, 62 * kStep_ns) == kAccelAxes);
    CHECK(stuck(70 * kStep_ns, stamp_ns) == kAccelAxes);
    buffer->replace(Timestamp{50 * kStep_ns}, Timestamp{stamp_ns}, kAccelAxes, kMotion);
    CHECK(stuck(70 * kStep_ns, stamp_ns) == kAccelAxes);
    REQUIRE(ok(buffer->push(ramp(stamp_ns += kStep_ns))));
    const std::int64_t again_ns = stamp_ns;
    hang(21);
    CHECK(stuck(again_ns, stamp_ns) == kAccelAxes);
    // The same, believed: from now on a run has to be four times as long.
    REQUIRE(ok(buffer->push(ramp(stamp_ns += kStep_ns))));
    const std::int64_t third_ns = stamp_ns;
    hang(80);
    CHECK(stuck(third_ns, stamp_ns) == 0);
    hang(1);
    CHECK(stuck(third_ns, stamp_ns) == kAccelAxes);
}

TEST_CASE("readings are restored to the bit", "[replaced_readings]") {
    const auto buffer = filled(41);
    buffer->set_replacement_noise({Eigen::Vector3d::Constant(0.25), Eigen::Vector3d::Constant(4.0)});
    buffer->replace(ms(0), ms(200), kGyroAxes | kAccelAxes, kMotion);
    buffer->replace(ms(50), ms(100), kGyroAxes, {});
    buffer->show_as_read(ms(100), ms(200));
    Preintegration shown;
    ImuSpan span;
    REQUIRE(ok(buffer->integrate_between(ms(105), ms(150), ImuNoise{}, shown, &span)));
    CHECK(span.is_replaced);
    CHECK(buffer->sample(30).w_B == ramp(30 * kStep_ns).w_B);
    buffer->restore(ms(0), ms(200));
    for (int k = 0; k < buffer->size(); ++k) {
        CHECK(buffer->sample(k).w_B == ramp(k * kStep_ns).w_B);
        CHECK(buffer->sample(k).a_B == ramp(k * kStep_ns).a_B);
    }
    REQUIRE(ok(buffer->integrate_between(ms(0), ms(200), ImuNoise{}, shown, &span)));
    CHECK_FALSE(span.is_replaced);
}

TEST_CASE("what was read can be integrated while it is replaced", "[replaced_readings]") {
    const auto buffer = filled(41);
    Preintegration read;
    REQUIRE(ok(buffer->integrate_between(ms(50), ms(100), ImuNoise{}, read)));
    buffer->replace(ms(45), ms(90), kGyroAxes | kAccelAxes, kMotion);
    buffer->replace(ms(90), ms(95), kGyroAxes, kMotion);
    Preintegration believed;
    REQUIRE(ok(buffer->integrate_between(ms(50), ms(100), ImuNoise{}, believed)));
    CHECK((believed.delta_v() - read.delta_v()).norm() > 0.01);
    buffer->exchange_as_read();
    Preintegration again;
    REQUIRE(ok(buffer->integrate_between(ms(50), ms(100), ImuNoise{}, again)));
    CHECK(again.delta_v() == read.delta_v());
    CHECK(again.delta_p() == read.delta_p());
    buffer->exchange_as_read();
    Preintegration restored;
    REQUIRE(ok(buffer->integrate_between(ms(50), ms(100), ImuNoise{}, restored)));
    CHECK(restored.delta_v() == believed.delta_v());
}

TEST_CASE("a sample that comes again is distinguished from one of another time", "[replaced_readings]") {
    const auto buffer = filled(41);
    CHECK(buffer->has(ramp(10 * kStep_ns)));
    ImuSample other = ramp(10 * kStep_ns);
    other.w_B.x() += 0.1;
    CHECK_FALSE(buffer->has(other));
    CHECK_FALSE(buffer->has(ramp(50 * kStep_ns)));
}

}  // namespace facet::replaced_readings_test
