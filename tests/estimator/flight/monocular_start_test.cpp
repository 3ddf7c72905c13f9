// SPDX-License-Identifier: BSD-2-Clause
// The closed-form start with one camera, on a closed-form flight.
#include "estimator/flight/monocular_start.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "tests/support/synthetic_flight.h"

using namespace facet;
using facet::test::SyntheticFlight;

namespace {

struct Fixture {
    SyntheticFlight flight;
    ImuBuffer imu;
    std::unique_ptr<MonocularStart> start = std::make_unique<MonocularStart>();
    NavState truth;
    NavState solved;
    MonocularStart::Information information;

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
    Fixture(const SyntheticFlight::Options& options, int keyframes) : flight(options) {
        const ImuNoise noise;
        const double end_s = 0.2 * keyframes;
        for (int k = 0; k <= std::lround(end_s / 0.005); ++k) {
            REQUIRE(ok(imu.push(flight.imu(0.005 * k))));
        }
        start->configure(flight.rig().T_B_C0, noise, 9.81, 2.0 * 0.3 / flight.rig().left.focal_px());
        for (int k = 0; k < keyframes; ++k) {
            const auto seen = flight.observe(0.2 * k);
            start->add_keyframe(test::at(0.2 * k), {seen.data(), seen.size()}, imu, {});
        }
        truth = flight.state(0.2 * (keyframes - 1));
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

TEST_CASE("velocity, gravity and gyroscope bias follow from one camera in motion", "[monocular_start]") {
    const auto seed = GENERATE(1U, 2U, 3U);
    Fixture f(Fixture::options(seed), 10);
    NavState nothing;  // the window knows nothing at all
    REQUIRE(ok(f.start->solve(nothing, f.solved, f.information)));
    CAPTURE(seed, f.velocity_error(), f.tilt_error());
    CHECK(f.velocity_error() < 0.15);
    CHECK(f.tilt_error() < 0.02);
    CHECK((f.solved.bias.gyro - Eigen::Vector3d(0.01, -0.02, 0.015)).norm() < 0.004);
}

TEST_CASE("a right state is confirmed, a wrong one contradicted", "[monocular_start]") {
    Fixture f(Fixture::options(1), 10);
    CHECK(f.start->check(f.truth, f.solved, f.information) == Status::kNotFound);
    NavState wrong = f.truth;
    wrong.v_W_B *= 0.3;
    wrong.v_W_B.x() += 0.6;
    CHECK(ok(f.start->check(wrong, f.solved, f.information)));
    CHECK(f.velocity_error() < 0.15);
}

TEST_CASE("a motion that does not show the scale gives no answer", "[monocular_start]") {
    SyntheticFlight::Options glide = Fixture::options(1);
    glide.motion = {0.0, 0.0, 0.0, Eigen::Vector3d::Zero(), {0.5, 0.1, 0.0}};
    Fixture f(glide, 10);
    CHECK(f.start->solve({}, f.solved, f.information) == Status::kDegenerate);
    Fixture few(Fixture::options(1), 3);
    CHECK(few.start->solve({}, few.solved, few.information) == Status::kNotReady);
}
