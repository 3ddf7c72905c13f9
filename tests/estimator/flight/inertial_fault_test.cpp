// SPDX-License-Identifier: BSD-2-Clause
// Whether readings or images are believed where they contradict each other, which sensor is at fault, and until when.
#include "estimator/flight/inertial_fault.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>

#include "estimator/imu/inertial_error.h"
#include "tests/support/synthetic_flight.h"

namespace facet::inertial_fault_test {

using facet::test::at;
using facet::test::SyntheticFlight;

namespace {

constexpr double kGravity = 9.81;

constexpr InertialFault::Limits kLimits{4.0, 25.0};

FrameEstimate frame(double chi2, int landmarks, int agreeing) {
    FrameEstimate out;
    out.chi2 = chi2;
    out.landmarks = landmarks;
    out.agreeing = agreeing;
    return out;
}

/// A flight whose readings have an error that the states do not know.
struct Faulty {
    explicit Faulty(const ImuBias& error)
        : flight([&error] {
              SyntheticFlight::Options options;
              options.bias = error;
              return options;
          }()) {}
    NavState state(double t) const {
        NavState s = flight.state(t);
        s.bias = {};
        return s;
    }
    Preintegration readings(double t0, double t1) { return flight.preintegrate(t0, t1, {}, ImuNoise{}); }
    void begin(InertialFault& fault, ImuAxisMask stuck = 0) {
        fault.begin(state(1.0), state(1.1), readings(1.0, 1.1), stuck);
    }
    /// A keyframe at t, two tenths of a second after the one before it.
    void judge(InertialFault& fault, double t) {
        fault.judge(state(t - 0.4), state(t - 0.2), state(t), readings(t - 0.4, t - 0.2), readings(t - 0.2, t));
    }

    SyntheticFlight flight;
};

const ImuBias kGyroFault{{0.5, 0.0, -0.3}, Eigen::Vector3d::Zero()};
const ImuBias kAccelFault{Eigen::Vector3d::Zero(), {0.0, 3.0, -4.0}};

/// A lively turn whose gyroscope works again, while its readings are still replaced from keyframe to keyframe.
struct Recovered {
    static constexpr double kPeriod_s = 0.2;

    /// @param hangs_until_s  the gyroscope of a vehicle that does not turn
    explicit Recovered(const SyntheticFlight::Options& options = turning(), double hangs_until_s = 0.0)
        : flight(options) {
        Faulty(kGyroFault).begin(fault, hangs_until_s > 0.0 ? kGyroAxes : ImuAxisMask{0});
        for (int k = 0; k <= 480; ++k) {
            ImuSample sample = flight.imu(0.005 * k);
            sample.w_B.x() += 0.005 * k > hangs_until_s && k % 2 == 0 ? 1e-6 : 0.0;
            REQUIRE(ok(imu->push(sample)));
        }
    }
    static SyntheticFlight::Options steady() {
        SyntheticFlight::Options options;
        options.motion.yaw_rad = options.motion.roll_rad = options.motion.pitch_rad = 0.0;
        return options;
    }
    static SyntheticFlight::Options turning() {
        SyntheticFlight::Options options;
        options.motion.yaw_rad = 7.0;
        options.motion.roll_rad = 1.0;
        options.motion.pitch_rad = 1.0;
        return options;
    }
    Keyframe keyframe(double t) {
        const double t0 = t - kPeriod_s;
        imu->replace(at(t0), at(t), kGyroAxes, {flight.rate(t0 - 0.05), Eigen::Vector3d::Zero(), {}});
        Preintegration replaced;
        REQUIRE(ok(imu->integrate_between(at(t0), at(t), noise, replaced)));
        Keyframe out;
        out.stamp = at(t);
        out.state = flight.state(t);
        REQUIRE(ok(out.imu_from_previous.set(replaced, noise)));
        return out;
    }
    /// A keyframe at t.
    void follow(double t) {
        const std::array<Keyframe, 3> last{keyframe(t - 2.0 * kPeriod_s), keyframe(t - kPeriod_s), keyframe(t)};
        fault.follow(last, *imu, noise, Preintegration{});
    }

    /// What the gyroscope seems to be off by at a keyframe at t if the mean of what was replaced is added to what its
    /// replacement leaves: right to first order only.
    double first_order(double t) {
        const Keyframe j = keyframe(t - kPeriod_s);
        const Keyframe k = keyframe(t);
        Eigen::Vector3d off = inertial_error(flight.state(t - 2.0 * kPeriod_s), j.state, k.state,
                                             j.imu_from_previous.preintegration(), k.imu_from_previous.preintegration())
                                  .gyro;
        constexpr int kSamples = 40;
        for (int s = 1; s <= kSamples; ++s) {
            const double read_at = t - kPeriod_s + 0.005 * s;
            off += (flight.rate(read_at) - flight.rate(t - kPeriod_s - 0.05)) / kSamples;
        }
        return off.norm();
    }

    SyntheticFlight flight;
    ImuNoise noise = test::euroc_like_noise();
    std::unique_ptr<ImuBuffer> imu = std::make_unique<ImuBuffer>(200.0);
    InertialFault fault;
};

}  // namespace

TEST_CASE("readings are suspected where images show one other motion, not where some of the scene moves",
          "[inertial_fault]") {
    CHECK_FALSE(InertialFault::is_called_for(frame(3.0, 200, 190), kLimits, false));
    CHECK(InertialFault::is_called_for(frame(900.0, 200, 3), kLimits, false));
    CHECK(InertialFault::is_justified(frame(900.0, 200, 3), frame(1.0, 200, 180), kLimits, false));
    // Four tenths of the tracks go with the readings: six tenths of the scene move.
    CHECK_FALSE(InertialFault::is_justified(frame(900.0, 200, 80), frame(1.0, 200, 120), kLimits, false));
    // No motion explains the images.
    CHECK_FALSE(InertialFault::is_justified(frame(900.0, 200, 3), frame(300.0, 200, 180), kLimits, false));
    CHECK_FALSE(InertialFault::is_justified(frame(900.0, 200, 3), frame(1.0, 200, 60), kLimits, false));
}

TEST_CASE("readings that images have bent are suspected where the scene is one piece", "[inertial_fault]") {
    FrameEstimate bent = frame(1.0, 200, 195);
    bent.inertial_chi2 = 100.0;
    CHECK(InertialFault::is_called_for(bent, kLimits, false));
    CHECK(InertialFault::is_justified(bent, frame(1.0, 200, 195), kLimits, false));
    CHECK_FALSE(
        InertialFault::is_justified(bent, frame(1.0, 200, 150), kLimits, false));  // a fourth of the scene moves
    bent.inertial_chi2 = 20.0;
    CHECK_FALSE(InertialFault::is_called_for(bent, kLimits, false));
}

TEST_CASE("of a sensor that hangs less contradiction is needed, but some, and by the whole scene", "[inertial_fault]") {
    const auto seen = [](double chi2, double inertial_chi2) {
        FrameEstimate out = frame(chi2, 200, 150);
        out.inertial_chi2 = inertial_chi2;
        return out;
    };
    for (const FrameEstimate& odd : {seen(5.0, 1.0), seen(1.0, 12.0)}) {
        CHECK_FALSE(InertialFault::is_called_for(odd, kLimits, false));
        CHECK(InertialFault::is_called_for(odd, kLimits, true));
        CHECK_FALSE(InertialFault::is_justified(odd, frame(1.0, 200, 195), kLimits, false));
        CHECK(InertialFault::is_justified(odd, frame(1.0, 200, 195), kLimits, true));
        CHECK_FALSE(InertialFault::is_justified(odd, frame(1.0, 200, 150), kLimits, true));  // a fourth moves
        CHECK_FALSE(InertialFault::is_justified(odd, frame(5.0, 200, 195), kLimits, true));
    }
    CHECK_FALSE(InertialFault::is_called_for(seen(3.0, 4.0), kLimits, true));
}

TEST_CASE("the sensor that hangs is the one at fault", "[inertial_fault]") {
    InertialFault fault;
    Faulty({}).begin(fault, kGyroAxes);  // nothing tells yet which of them it is
    CHECK(fault.axes() == kGyroAxes);
    Faulty({}).begin(fault, kGyroAxes);  // contradicted again, with that one replaced
    CHECK(fault.axes() == (kGyroAxes | kAccelAxes));
    fault.end();
    Faulty({}).begin(fault, kGyroAxes | kAccelAxes);
    CHECK(fault.axes() == (kGyroAxes | kAccelAxes));
    fault.end();
    Faulty(kAccelFault).begin(fault, kGyroAxes);  // a gyroscope that repeats, without noise, and is right
    CHECK(fault.axes() == kAccelAxes);
    Faulty({}).begin(fault, kGyroAxes);
    CHECK(fault.axes() == (kGyroAxes | kAccelAxes));
}

TEST_CASE("the sensor at fault is found; both are suspected where that is unclear", "[inertial_fault]") {
    InertialFault fault;
    CHECK_FALSE(fault.is_active());
    Faulty(kGyroFault).begin(fault);
    CHECK(fault.axes() == kGyroAxes);
    fault.end();
    CHECK_FALSE(fault.is_active());
    Faulty(kAccelFault).begin(fault);
    CHECK(fault.axes() == kAccelAxes);
    Faulty(kAccelFault).begin(fault);  // contradicted again, with one of them replaced
    CHECK(fault.axes() == (kGyroAxes | kAccelAxes));
    fault.end();
    Faulty({kGyroFault.gyro, kAccelFault.accel}).begin(fault);
    CHECK(fault.axes() == (kGyroAxes | kAccelAxes));
}

TEST_CASE("the noise is what the replaced readings leave", "[inertial_fault]") {
    InertialFault fault;
    Faulty faulty(kAccelFault);
    faulty.begin(fault);
    fault.measure(faulty.state(1.0), faulty.state(1.1), faulty.readings(1.0, 1.1));
    CHECK(fault.noise().accel.x() == Approx(0.25 * 25.0).epsilon(0.02));  // 5 m/s^2 for 0.25 s
    CHECK(fault.noise().gyro.x() < 0.25 * 0.03 * 0.03);
}

TEST_CASE("the doubt ends when the readings have agreed at two keyframes in a row", "[inertial_fault]") {
    InertialFault fault;
    Faulty faulty(kGyroFault);
    Faulty right({});
    faulty.begin(fault);
    faulty.judge(fault, 1.6);
    CHECK(fault.is_active());
    right.judge(fault, 1.8);
    CHECK(fault.is_active());
    faulty.judge(fault, 2.0);
    right.judge(fault, 2.2);
    CHECK(fault.is_active());
    right.judge(fault, 2.4);
    CHECK_FALSE(fault.is_active());
}

TEST_CASE("however lively the turn, a gyroscope that works again is believed after two keyframes", "[inertial_fault]") {
    Recovered recovered;
    REQUIRE(recovered.fault.axes() == kGyroAxes);
    recovered.follow(1.6);
    CHECK(recovered.fault.is_active());
    recovered.follow(1.8);
    CHECK_FALSE(recovered.fault.is_active());
    // More than 30 mrad/s, which is what the keyframes can tell: by the first order it would not be believed.
    CHECK(recovered.first_order(1.6) > 0.03);
    CHECK(recovered.first_order(1.8) > 0.03);
}

TEST_CASE("a sensor is not believed while it hangs, though it may read what is right", "[inertial_fault]") {
    Recovered hanging(Recovered::steady(), 1.5);
    REQUIRE(hanging.fault.axes() == kGyroAxes);
    for (int k = 0; k < 4; ++k) {
        hanging.follow(1.0 + 0.2 * k);
        CHECK(hanging.fault.is_active());
    }
    hanging.follow(1.8);  // the readings since 1.4 s: some of them hang
    CHECK(hanging.fault.is_active());
    hanging.follow(2.0);  // the reason for the doubt is gone: once is enough
    CHECK_FALSE(hanging.fault.is_active());
}

TEST_CASE("a steady motion goes on at the rate of the last two frames", "[inertial_fault]") {
    const Faulty right({});
    InertialFault fault;
    fault.see(at(1.0), right.state(1.0));
    fault.see(at(1.02), right.state(1.02));
    const SteadyMotion steady = fault.steady(right.state(1.02), kGravity);
    CHECK((steady.w_B - right.flight.rate(1.01)).norm() < 1e-3);
    CHECK((right.state(1.02).q_W_B * steady.a_B - Eigen::Vector3d(0.0, 0.0, kGravity)).norm() < 1e-9);
}

}  // namespace facet::inertial_fault_test
