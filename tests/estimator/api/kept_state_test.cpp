// SPDX-License-Identifier: BSD-2-Clause
// An estimator that goes on from what an earlier one has kept.
#include "estimator/api/kept_state.h"

#include <cmath>

#include "tests/support/still_vehicle.h"

namespace facet::kept_state_test {

using facet::test::StillVehicle;

namespace {

/// A program's estimator on the vehicle, which stands.
struct Program {
    explicit Program(const StillVehicle& still) : vehicle(still) { REQUIRE(ok(estimator.configure({}, vehicle.rig))); }

    /// @return seconds until the first TRACKING, or infinity
    double fly(double begin_s, double duration_s) {
        double tracking_after_s = INFINITY;
        for (int k = 0; k < std::lround(duration_s / 0.05); ++k) {
            const double t = begin_s + 0.05 * k;
            vehicle.feed_imu(estimator, t, t + 0.05);
            REQUIRE(ok(estimator.add_frame(vehicle.frame(t + 0.04), estimate)));
            const bool tracks = estimate.health.state == TrackingState::kTracking;
            tracking_after_s = tracks ? std::min(tracking_after_s, 0.05 * (k + 1)) : tracking_after_s;
        }
        return tracking_after_s;
    }

    const StillVehicle& vehicle;
    Estimator estimator;
    Estimate estimate;
};

KeptState somewhere() {
    KeptState kept;
    kept.state.q_W_B = Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitZ());
    kept.state.p_W_B = {10.0, -20.0, 3.0};
    kept.state.bias.accel = {0.02, 0.0, 0.0};
    kept.sigma << 0.001, 0.001, 0.01, 0.05, 0.05, 0.03, 0.01, 0.01, 0.01, 1e-4, 1e-4, 1e-4, 0.005, 0.005, 0.005;
    kept.calibration.correction.time_offset_s = 0.004;
    kept.calibration.sigma.setConstant(1e-3);
    kept.calibration.sigma(kTimeOffset) = 1e-5;
    return kept;
}

double yaw(const Eigen::Quaterniond& q) {
    const Eigen::Matrix3d R = q.toRotationMatrix();
    return std::atan2(R(1, 0), R(0, 0));
}

}  // namespace

TEST_CASE("what one estimator keeps another one goes on from", "[kept_state]") {
    const StillVehicle vehicle;
    Program first(vehicle);
    REQUIRE(ok(first.estimator.resume(somewhere(), 0.5)));
    CHECK(first.fly(100.0, 3.0) < 2.0);
    CHECK(first.estimate.health.reset_counter == 0);  // this estimator has given no pose that this one could jump from
    CHECK((first.estimate.state.p_W_B - somewhere().state.p_W_B).norm() < 0.05);
    CHECK(yaw(first.estimate.state.q_W_B) == Approx(1.2).margin(0.02));
    // Half a second is 1 m and 0.25 rad of what it may have done.
    CHECK(std::sqrt(first.estimate.covariance(3, 3)) == Approx(1.0).margin(0.1));
    CHECK(std::sqrt(first.estimate.covariance(2, 2)) == Approx(0.25).margin(0.05));
    CHECK(first.estimator.calibration().correction.time_offset_s == Approx(0.004).margin(1e-4));
    CHECK(first.estimate.state.bias.accel.x() == Approx(0.02).margin(0.01));

    const KeptState kept = first.estimator.keep();
    CHECK(kept.state.p_W_B == first.estimate.state.p_W_B);
    CHECK(kept.sigma(kPos) == Approx(std::sqrt(first.estimate.covariance(3, 3))));
    Program second(vehicle);
    REQUIRE(ok(second.estimator.resume(kept, 1.0)));
    CHECK(second.fly(200.0, 2.0) < 2.0);
    CHECK((second.estimate.state.p_W_B - first.estimate.state.p_W_B).norm() < 0.05);
    CHECK(second.estimate.covariance(3, 3) > first.estimate.covariance(3, 3));
    CHECK(second.estimate.state.bias.accel.x() == Approx(0.02).margin(0.01));
    second.estimator.request_reset();
    second.fly(202.0, 1.0);
    CHECK(second.estimate.health.reset_counter == 1);
}

TEST_CASE("a calibration of which nothing was found is the one that was given", "[kept_state]") {
    const StillVehicle vehicle;
    KeptState kept = somewhere();
    kept.calibration = {};
    Program program(vehicle);
    REQUIRE(ok(program.estimator.resume(kept, 0.5)));
    program.fly(100.0, 1.0);
    CHECK((program.estimate.state.p_W_B - kept.state.p_W_B).norm() < 0.05);
    CHECK(std::abs(program.estimator.calibration().correction.time_offset_s) < 1e-3);
}

TEST_CASE("a vehicle that stands keeps what it was given, however often it is started again", "[kept_state]") {
    const StillVehicle vehicle;
    KeptState kept = somewhere();
    for (int start = 0; start < 3; ++start) {
        Program program(vehicle);
        CAPTURE(start);
        REQUIRE(ok(program.estimator.resume(kept, 0.1)));
        program.fly(100.0, 0.6);
        kept = program.estimator.keep();
        CHECK((kept.state.p_W_B - somewhere().state.p_W_B).norm() < 0.05);
        CHECK(kept.calibration.correction.time_offset_s == Approx(0.004).margin(2e-4));
        CHECK(kept.calibration.sigma(kTimeOffset) > 0.0);
    }
}

TEST_CASE("what is not fit to go on from is refused, and the start is the usual one", "[kept_state]") {
    const StillVehicle vehicle;
    const auto worsen = GENERATE(0, 1, 2, 3, 4, 5);
    CAPTURE(worsen);
    KeptState kept = somewhere();
    double elapsed_s = 1.0;
    switch (worsen) {
        case 0: kept.state.p_W_B.x() = NAN; break;
        case 1: kept.state.q_W_B.coeffs() *= 2.0; break;
        case 2: kept.sigma(kVel) = 0.0; break;
        case 3: kept.calibration.sigma(kTimeOffset) = -1.0; break;
        case 4: elapsed_s = -1.0; break;
        default: elapsed_s = NAN; break;
    }
    Program program(vehicle);
    CHECK(program.estimator.resume(kept, elapsed_s) == Status::kInvalidArgument);
    program.fly(100.0, 1.0);
    CHECK(program.estimate.health.reset_counter == 0);
    CHECK(program.estimate.state.p_W_B.norm() < 0.05);
}

}  // namespace facet::kept_state_test
