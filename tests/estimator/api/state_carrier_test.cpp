// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/state_carrier.h"

#include <catch2/catch.hpp>
#include <memory>

#include "tests/support/allocation_guard.h"
#include "tests/support/synthetic_flight.h"

namespace facet::state_carrier_test {

using facet::test::at;
using facet::test::SyntheticFlight;

namespace {

constexpr double kPeriod_s = 0.005;

SyntheticFlight::Options noisy() {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    return options;
}

/// A flight, a carrier, and a history for reference.
struct Carried {
    SyntheticFlight flight{noisy()};
    ImuNoise noise = test::euroc_like_noise();
    std::unique_ptr<StateCarrier> carrier = std::make_unique<StateCarrier>();
    std::unique_ptr<ImuBuffer> reference = std::make_unique<ImuBuffer>(noise.rate_hz);

    explicit Carried(double smoothing_s = 0.0) { carrier->configure(noise, {}, 9.81, smoothing_s); }

    Status add(double t) {
        const ImuSample sample = flight.imu(t);
        (void)reference->push(sample);
        return carrier->add_imu(sample);
    }
    Belief belief(double t) const {
        Belief b{at(t), flight.state(t), StateCovariance::Identity() * 1e-4, {}, {}, {}};
        b.state.bias.gyro.x() += 1e-3;
        return b;
    }
    /// The belief carried on by all samples at once.
    NavState expected(const Belief& from, StateCovariance& covariance) const {
        Preintegration p(from.state.bias);
        REQUIRE(ok(reference->integrate_between(from.stamp, reference->newest(), noise, p)));
        covariance = propagate_covariance(from.state, from.covariance, p, noise);
        return p.predict(from.state);
    }
    void check_equals(const Belief& from) const {
        StateCovariance covariance;
        const NavState state = expected(from, covariance);
        CHECK(state.box_minus_to(carrier->state()).norm() < 1e-9);
        CHECK((covariance - carrier->covariance()).norm() < 1e-3 * covariance.norm());
    }
};

double distance(const NavState& a, const NavState& b) { return a.box_minus_to(b).head<kBiasGyro>().norm(); }

}  // namespace

TEST_CASE("the carried state is the belief propagated by all samples since", "[state_carrier]") {
    Carried c;
    for (int i = 0; i <= 20; ++i) {
        REQUIRE(ok(c.add(kPeriod_s * i)));
        CHECK_FALSE(c.carrier->has_state());
    }
    const Belief first = c.belief(0.0523);  // between two samples
    REQUIRE(ok(c.carrier->correct(first)));
    c.check_equals(first);
    for (int i = 21; i <= 40; ++i) {
        REQUIRE(ok(c.add(kPeriod_s * i)));
        CHECK(c.carrier->stamp() == at(kPeriod_s * i));
        c.check_equals(first);
    }
    const Belief second = c.belief(0.1);
    REQUIRE(ok(c.carrier->correct(second)));
    c.check_equals(second);
    REQUIRE(ok(c.add(kPeriod_s * 41)));
    c.check_equals(second);
}

TEST_CASE("stamps of carried states never go backwards", "[state_carrier]") {
    Carried c;
    Timestamp last = at(-1.0);
    for (int i = 0; i <= 200; ++i) {
        const Status added = c.add(kPeriod_s * (i % 50 == 49 ? i - 3 : i));  // now and then an old sample
        CHECK(ok(added) == (i % 50 != 49));
        if (ok(added) && c.carrier->has_state()) {
            CHECK(c.carrier->stamp() > last);
            last = c.carrier->stamp();
        }
        if (i % 10 == 9) {
            const Timestamp before = c.carrier->has_state() ? c.carrier->stamp() : last;
            REQUIRE(ok(c.carrier->correct(c.belief(kPeriod_s * (i - 5)))));
            CHECK(c.carrier->stamp() >= before);
        }
    }
    CHECK(c.carrier->correct(c.belief(0.5)) == Status::kOutOfOrder);
    CHECK(c.carrier->correct(c.belief(2.0)) == Status::kNotReady);
    c.carrier->forget();
    CHECK_FALSE(c.carrier->has_state());
    REQUIRE(ok(c.carrier->correct(c.belief(0.9))));
    CHECK(c.carrier->has_state());
}

TEST_CASE("a smoothed correction makes no step and is complete after a while", "[state_carrier]") {
    constexpr double kSmoothing_s = 0.05;
    Carried c(kSmoothing_s);
    for (int i = 0; i <= 20; ++i) {
        REQUIRE(ok(c.add(kPeriod_s * i)));
    }
    REQUIRE(ok(c.carrier->correct(c.belief(0.05))));
    const NavState before = c.carrier->state();
    Belief moved = c.belief(0.1);
    moved.state.p_W_B.x() += 0.02;
    moved.state.q_W_B = moved.state.q_W_B * so3_exp({0.0, 0.01, 0.0});
    REQUIRE(ok(c.carrier->correct(moved)));
    CHECK(distance(c.carrier->state(), before) < 1e-9);
    StateCovariance covariance;
    REQUIRE(ok(c.add(kPeriod_s * 21)));
    const double soon = distance(c.carrier->state(), c.expected(moved, covariance));
    CHECK(soon > 0.015);
    for (int i = 22; i <= 20 + 60; ++i) {
        REQUIRE(ok(c.add(kPeriod_s * i)));
    }
    CHECK(distance(c.carrier->state(), c.expected(moved, covariance)) < 0.005 * soon);  // exp(-6)
}

TEST_CASE("carrying a state uses no heap", "[state_carrier]") {
    Carried c;
    for (int i = 0; i <= 20; ++i) {
        REQUIRE(ok(c.add(kPeriod_s * i)));
    }
    const Belief belief = c.belief(0.05);
    const ImuSample sample = c.flight.imu(kPeriod_s * 21);
    const test::AllocationGuard guard;
    (void)c.carrier->correct(belief);
    (void)c.carrier->add_imu(sample);
    const double height = c.carrier->state().p_W_B.z() + c.carrier->covariance()(0, 0);
    const std::uint64_t allocations = guard.allocations();
    CHECK(allocations == 0);
    CHECK(std::isfinite(height));
}

TEST_CASE("readings that the belief doubts are not carried on with, until a belief trusts them", "[state_carrier]") {
    Carried c;
    for (int i = 0; i <= 10; ++i) {
        REQUIRE(ok(c.add(kPeriod_s * i)));
    }
    Belief doubting = c.belief(0.05);
    doubting.state.bias = {};
    doubting.replaced.axes = kGyroAxes;
    doubting.replaced.motion.w_B = c.flight.rate(0.05);
    doubting.replaced.noise.gyro.setConstant(0.01);
    REQUIRE(ok(c.carrier->correct(doubting)));
    const auto add_garbage = [&c](int i) {
        ImuSample sample = c.flight.imu(kPeriod_s * i);
        sample.w_B = {3.0, -2.0, 1.0};
        REQUIRE(ok(c.carrier->add_imu(sample)));
    };
    for (int i = 11; i <= 20; ++i) {
        add_garbage(i);
    }
    // As far as a steady rate for 50 ms differs from the flight, and no farther.
    CHECK(distance(c.carrier->state(), c.flight.state(0.1)) < 0.02);
    CHECK(c.carrier->covariance()(0, 0) > 1e-4 + 0.9 * 0.01 * 0.05);

    Belief trusting = doubting;
    trusting.replaced = {};
    REQUIRE(ok(c.carrier->correct(trusting)));
    CHECK(distance(c.carrier->state(), c.flight.state(0.1)) > 0.1);
}

TEST_CASE("samples that go on in the past begin a new history, single ones do not", "[state_carrier]") {
    Carried c;
    for (int k = 0; k < 200; ++k) {
        REQUIRE(ok(c.add(3600.0 + kPeriod_s * k)));
    }
    REQUIRE(ok(c.carrier->correct(c.belief(3600.9))));
    for (int k = 0; k < 10; ++k) {
        CHECK(c.add(5.0 + k) == Status::kOutOfOrder);
    }
    CHECK(c.carrier->has_state());
    int refused = 0;
    for (int k = 0; k < 200; ++k) {
        refused += ok(c.add(1.0 + kPeriod_s * k)) ? 0 : 1;
    }
    CHECK(refused == 100);
    CHECK_FALSE(c.carrier->has_state());
    const Belief belief = c.belief(1.8);
    REQUIRE(ok(c.carrier->correct(belief)));
    CHECK(c.carrier->stamp() == at(1.0 + kPeriod_s * 199));
}

}  // namespace facet::state_carrier_test
