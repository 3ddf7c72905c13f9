// SPDX-License-Identifier: BSD-2-Clause
// A start in motion, with two cameras and with one, on a closed-form flight.
#include "estimator/flight/motion_start.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "tests/support/allocation_guard.h"
#include "tests/support/synthetic_flight.h"

namespace facet::motion_start_test {

using facet::test::SyntheticFlight;

namespace {

struct Fixture {
    SyntheticFlight flight;
    ImuBuffer imu;
    std::unique_ptr<MotionStart> start = std::make_unique<MotionStart>();
    NavState truth;
    NavState solved;
    MotionStart::Information information;

    static SyntheticFlight::Options options(unsigned seed) {
        SyntheticFlight::Options o;
        o.gyro_noise = 1.7e-4;
        o.accel_noise = 2e-3;
        o.pixel_sigma = 0.3;
        o.bias.gyro = {0.01, -0.02, 0.015};
        o.bias.accel = {0.05, -0.04, 0.03};
        o.seed = seed;
        return o;
    }
    /// Biases as before a flight.
    static Belief unknown() {
        Belief belief;
        belief.covariance.setIdentity();
        return belief;
    }
    Fixture(const SyntheticFlight::Options& options, int keyframes, bool is_stereo, double step_s = 0.2,
            double begin_s = 0.0, const Belief& belief = unknown())
        : flight(options) {
        for (int k = 0; k <= std::lround((begin_s + step_s * keyframes) / 0.005); ++k) {
            REQUIRE(ok(imu.push(flight.imu(0.005 * k))));
        }
        start->configure(flight.rig(), ImuNoise{}, 9.81, 2.0 * 0.3 / flight.rig().left.focal_px());
        for (int k = 0; k < keyframes; ++k) {
            auto seen = flight.observe(begin_s + step_s * k);
            for (FeatureObservation& o : seen) {
                o.has_right = o.has_right && is_stereo;
            }
            start->add_keyframe(test::at(begin_s + step_s * k), {seen.data(), seen.size()}, imu, belief);
        }
        truth = flight.state(begin_s + step_s * (keyframes - 1));
    }
    double velocity_error() const {
        return (solved.q_W_B.conjugate() * solved.v_W_B - truth.q_W_B.conjugate() * truth.v_W_B).norm();
    }
    double tilt_error() const {
        const Eigen::Vector3d up = solved.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
        return up.cross(truth.q_W_B.conjugate() * Eigen::Vector3d::UnitZ()).norm();
    }
};

}  // namespace

TEST_CASE("velocity, gravity and gyroscope bias follow from one camera in motion", "[motion_start]") {
    const auto seed = GENERATE(1U, 2U, 3U);
    SyntheticFlight::Options lively = Fixture::options(seed);
    lively.motion.place_m *= 1.5;
    Fixture f(lively, 12, false);
    NavState nothing;  // the window knows nothing at all
    REQUIRE(ok(f.start->solve(nothing, f.solved, f.information)));
    CAPTURE(seed, f.velocity_error(), f.tilt_error());
    CHECK(f.velocity_error() < 0.15);
    CHECK(f.tilt_error() < 0.02);
    CHECK((f.solved.bias.gyro - Eigen::Vector3d(0.01, -0.02, 0.015)).norm() < 0.004);
}

TEST_CASE("two cameras give velocity and gravity within a third of a second", "[motion_start]") {
    const auto seed = GENERATE(1U, 2U, 3U);
    Fixture f(Fixture::options(seed), 4, true, 0.1);
    NavState nothing;
    REQUIRE(ok(f.start->solve(nothing, f.solved, f.information)));
    CAPTURE(seed, f.velocity_error(), f.tilt_error());
    CHECK(f.velocity_error() < 0.1);
    CHECK(f.tilt_error() < 0.05);
    CHECK(f.information.llt().info() == Eigen::Success);
}

TEST_CASE("two cameras give the velocity of a glide", "[motion_start]") {
    SyntheticFlight::Options glide = Fixture::options(1);
    glide.motion = {0.0, 0.0, 0.0, Eigen::Vector3d::Zero(), {0.5, 0.1, 0.0}};
    Fixture f(glide, 6, true);
    REQUIRE(ok(f.start->solve({}, f.solved, f.information)));
    CHECK(f.velocity_error() < 0.05);
    CHECK(f.tilt_error() < 0.03);
}

TEST_CASE("a right state is confirmed", "[motion_start]") {
    const bool is_stereo = GENERATE(false, true);
    Fixture f(Fixture::options(1), 10, is_stereo);
    CHECK(f.start->check(f.truth, f.solved, f.information) == Status::kNotFound);
}

TEST_CASE("a state with gravity or velocity far off is contradicted, position and yaw stay", "[motion_start]") {
    const bool is_stereo = GENERATE(false, true);
    Fixture f(Fixture::options(1), 10, is_stereo);
    NavState wrong = f.truth;
    SECTION("tilt") { wrong.q_W_B = so3_exp({0.9, -0.4, 0.0}) * f.truth.q_W_B; }
    SECTION("velocity") { wrong.v_W_B += Eigen::Vector3d(1.0, -2.0, 0.5); }
    REQUIRE(ok(f.start->check(wrong, f.solved, f.information)));
    CHECK(f.velocity_error() < 0.15);
    CHECK(f.tilt_error() < 0.02);
    CHECK(f.solved.p_W_B == wrong.p_W_B);
    // No turn about the vertical is left between what was given and what came back.
    const Eigen::Matrix3d turn = (wrong.q_W_B * f.solved.q_W_B.conjugate()).toRotationMatrix();
    CHECK(std::abs(turn(1, 0) - turn(0, 1)) < 1e-9);
    CHECK(f.information.llt().info() == Eigen::Success);
}

TEST_CASE("a motion that does not show the scale gives no answer with one camera", "[motion_start]") {
    SyntheticFlight::Options glide = Fixture::options(1);
    glide.motion = {0.0, 0.0, 0.0, Eigen::Vector3d::Zero(), {0.5, 0.1, 0.0}};
    Fixture f(glide, 10, false);
    CHECK(f.start->solve({}, f.solved, f.information) == Status::kDegenerate);
}

TEST_CASE("one camera finds velocity although the gyroscope's bias is unknown", "[motion_start]") {
    const auto seed = GENERATE(1U, 2U, 3U);
    SyntheticFlight::Options biased = Fixture::options(seed);
    biased.bias.gyro = {-0.003, 0.02, 0.08};  // as in EuRoC
    biased.motion.place_m *= 1.5;
    Fixture f(biased, 12, false);
    REQUIRE(ok(f.start->solve({}, f.solved, f.information)));
    CAPTURE(seed, f.velocity_error(), f.tilt_error());
    CHECK(f.velocity_error() < 0.15);
    CHECK(f.velocity_error() < 4.0 / std::sqrt(f.information.diagonal().segment<3>(kVel).minCoeff()));
    CHECK(f.tilt_error() < 0.02);
    CHECK((f.solved.bias.gyro - biased.bias.gyro).norm() < 0.004);
}

TEST_CASE("one camera needs fewer keyframes where biases are known", "[motion_start]") {
    const auto seed = GENERATE(1U, 2U, 3U);
    const SyntheticFlight::Options options = Fixture::options(seed);
    Belief kept;  // as an earlier program has left it, with errors of one sigma
    kept.state.bias.gyro = options.bias.gyro + Eigen::Vector3d(1e-3, -1e-3, 1e-3);
    kept.state.bias.accel = options.bias.accel + Eigen::Vector3d(-0.01, 0.01, 0.01);
    kept.covariance.diagonal().segment<3>(kBiasGyro).setConstant(1e-6);
    kept.covariance.diagonal().segment<3>(kBiasAccel).setConstant(1e-4);
    const auto fewest_keyframes = [&](const Belief& belief) {
        for (int keyframes = 6; keyframes <= 12; ++keyframes) {
            Fixture f(options, keyframes, false, 0.2, 0.0, belief);
            if (ok(f.start->solve({}, f.solved, f.information))) {
                CAPTURE(keyframes, f.velocity_error());
                CHECK(f.velocity_error() < 3.0 / std::sqrt(f.information.diagonal().segment<3>(kVel).minCoeff()));
                return keyframes;
            }
        }
        return 13;
    };
    CAPTURE(seed);
    CHECK(fewest_keyframes(kept) < fewest_keyframes(Fixture::unknown()));
}

TEST_CASE("one camera gives no answer before the scale of its path is known", "[motion_start]") {
    const int keyframes = GENERATE(4, 6, 12);
    SyntheticFlight::Options standing = Fixture::options(1);
    standing.motion = {0.0, 0.0, 0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    Fixture f(standing, keyframes, false);
    CHECK(f.start->solve({}, f.solved, f.information) == Status::kDegenerate);
}

TEST_CASE("one camera finds by how much its images are early, and gives no answer then", "[motion_start]") {
    const auto seed = GENERATE(1U, 2U, 3U);
    const bool is_early = GENERATE(false, true);
    SyntheticFlight::Options lively = Fixture::options(seed);
    lively.motion.place_m *= 1.5;
    lively.motion.yaw_rad = 1.2;
    lively.motion.pitch_rad = lively.motion.roll_rad = 0.5;
    lively.time_offset_s = is_early ? -0.055 : 0.0;
    Fixture f(lively, 12, false, 0.2, 0.1);  // samples reach back from the oldest keyframe
    const test::AllocationGuard guard;
    const Status status = f.start->solve({}, f.solved, f.information);
    const std::uint64_t allocations = guard.allocations();
    CAPTURE(seed, is_early);
    CHECK(allocations == 0);
    CHECK_FALSE((is_early && ok(status)));
    REQUIRE(f.start->delay().has_value() == is_early);
    // To first order, and by a prior: what is left is found by the start after it.
    CHECK(f.start->delay().value_or(ImageDelay{}).value_s == Approx(lively.time_offset_s).margin(0.02));
}

TEST_CASE("too few keyframes give no answer", "[motion_start]") {
    Fixture alone(Fixture::options(1), 3, false);
    CHECK(alone.start->solve({}, alone.solved, alone.information) == Status::kNotReady);
    Fixture pair(Fixture::options(1), 3, true);
    CHECK(pair.start->solve({}, pair.solved, pair.information) == Status::kNotReady);
}

}  // namespace facet::motion_start_test
