// SPDX-License-Identifier: BSD-2-Clause
// The second opinion on a start in motion, on a closed-form flight.
#include "estimator/flight/motion_start.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/synthetic_flight.h"

using namespace facet;
using facet::test::SyntheticFlight;

namespace {

struct Fixture {
    SyntheticFlight flight;
    ImuBuffer imu;
    MotionStart start;
    NavState truth;

    static SyntheticFlight::Options options() {
        SyntheticFlight::Options o;
        o.gyro_noise = 1.7e-4;
        o.accel_noise = 2e-3;
        o.pixel_sigma = 0.3;
        return o;
    }
    explicit Fixture(int keyframes) : flight(options()) {
        ImuNoise noise;
        for (int k = 0; k <= 400; ++k) {
            REQUIRE(ok(imu.push(flight.imu(0.005 * k))));
        }
        start.configure(flight.rig(), noise, 9.81, 0.3);
        for (int k = 0; k < keyframes; ++k) {
            const auto seen = flight.observe(0.2 * k);
            start.add_keyframe(test::at(0.2 * k), {seen.data(), seen.size()}, imu);
        }
        truth = flight.state(0.2 * (keyframes - 1));
    }
};

}  // namespace

TEST_CASE("a state that is right is left alone", "[motion_start]") {
    const Fixture f(6);
    NavState better;
    Eigen::Matrix<double, kStateDim, kStateDim> information;
    CHECK(f.start.check(f.truth, better, information) == Status::kNotFound);
}

TEST_CASE("a state with gravity or velocity far off is contradicted, position and yaw stay", "[motion_start]") {
    const Fixture f(6);
    NavState wrong = f.truth;
    SECTION("tilt") { wrong.q_W_B = so3_exp({0.9, -0.4, 0.0}) * f.truth.q_W_B; }
    SECTION("velocity") { wrong.v_W_B += Eigen::Vector3d(1.0, -2.0, 0.5); }
    NavState better;
    Eigen::Matrix<double, kStateDim, kStateDim> information;
    REQUIRE(ok(f.start.check(wrong, better, information)));
    CHECK(better.p_W_B == wrong.p_W_B);
    const Eigen::Vector3d up = better.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up_true = f.truth.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    CHECK(up.cross(up_true).norm() < 0.02);
    const Eigen::Vector3d v_B = better.q_W_B.conjugate() * better.v_W_B;
    CHECK((v_B - f.truth.q_W_B.conjugate() * f.truth.v_W_B).norm() < 0.08);
    // No turn about the vertical is left between what was given and what came back.
    const Eigen::Matrix3d turn = (wrong.q_W_B * better.q_W_B.conjugate()).toRotationMatrix();
    CHECK(std::abs(turn(1, 0) - turn(0, 1)) < 1e-9);
    CHECK(information.llt().info() == Eigen::Success);
}

TEST_CASE("two keyframes are not enough for an opinion", "[motion_start]") {
    const Fixture f(2);
    NavState wrong = f.truth;
    wrong.v_W_B.setConstant(3.0);
    NavState better;
    Eigen::Matrix<double, kStateDim, kStateDim> information;
    CHECK(f.start.check(wrong, better, information) == Status::kNotFound);
}
