// SPDX-License-Identifier: BSD-2-Clause
// Errors of inertial readings from states that owe nothing to them: exact for constant errors, up to the first order.
#include "estimator/imu/inertial_error.h"

#include <catch2/catch.hpp>

#include "tests/support/synthetic_flight.h"

namespace facet::inertial_error_test {

using facet::test::SyntheticFlight;

namespace {

const ImuBias kError{{0.02, -0.05, 0.03}, {0.4, -0.2, 0.3}};

/// A flight whose readings have this error, which the states' bias does not know.
NavState without_bias(NavState state) {
    state.bias = {};
    return state;
}

}  // namespace

TEST_CASE("an error of the readings is found from two states", "[inertial_error]") {
    SyntheticFlight::Options options;
    options.bias = kError;
    SyntheticFlight flight(options);
    const Preintegration ij = flight.preintegrate(1.0, 1.1, {}, ImuNoise{});
    const ImuBias found = inertial_error(without_bias(flight.state(1.0)), without_bias(flight.state(1.1)), ij);
    CHECK((found.gyro - kError.gyro).norm() < 1e-3);
    CHECK((found.accel - kError.accel).norm() < 0.03);
}

TEST_CASE("from three poses it is found whatever the velocities are", "[inertial_error]") {
    SyntheticFlight::Options options;
    options.bias = kError;
    SyntheticFlight flight(options);
    const Preintegration ij = flight.preintegrate(1.0, 1.2, {}, ImuNoise{});
    const Preintegration jk = flight.preintegrate(1.2, 1.35, {}, ImuNoise{});
    NavState i = without_bias(flight.state(1.0));
    NavState j = without_bias(flight.state(1.2));
    i.v_W_B += Eigen::Vector3d(3.0, -2.0, 1.0);
    j.v_W_B.setZero();
    const ImuBias found = inertial_error(i, j, without_bias(flight.state(1.35)), ij, jk);
    CHECK((found.gyro - kError.gyro).norm() < 2e-3);
    CHECK((found.accel - kError.accel).norm() < 0.08);  // the body turns by 0.1 rad meanwhile
}

TEST_CASE("right readings have no error, and neither has an empty interval", "[inertial_error]") {
    SyntheticFlight flight(SyntheticFlight::Options{});
    const NavState i = flight.state(2.0);
    const NavState j = flight.state(2.2);
    const ImuBias found = inertial_error(i, j, flight.preintegrate(2.0, 2.2, {}, ImuNoise{}));
    CHECK(found.gyro.norm() < 1e-3);
    CHECK(found.accel.norm() < 0.01);
    const ImuBias none = inertial_error(i, j, Preintegration{});
    CHECK(none.gyro == Eigen::Vector3d::Zero());
    CHECK(none.accel == Eigen::Vector3d::Zero());
}

}  // namespace facet::inertial_error_test
