// SPDX-License-Identifier: BSD-2-Clause
// A sensor that hangs is suspected by what a living one could say as well, and for as long as it hangs.
#include <cmath>

#include "tests/support/still_vehicle.h"

namespace facet::hanging_sensor_test {

using facet::test::at;
using facet::test::StillVehicle;

namespace {

/// A vehicle at rest whose accelerometer may hang at a wrong reading, or read it and live.
struct Flight {
    Flight() {
        REQUIRE(ok(estimator.configure({}, vehicle.rig)));
        feed(0.5);
        fly(2.5);
        REQUIRE(estimate.health.state == TrackingState::kTracking);
        before = estimate.state.p_W_B;
    }
    void feed(double duration_s) {
        const int samples = static_cast<int>(std::lround(duration_s / kStep_s));
        for (int k = 0; k < samples; ++k, ++count) {
            const double noise = count % 2 == 0 ? 1e-3 : -1e-3;
            ImuSample sample{at(kStep_s * count), {0.001 + 1e-5 * noise, -0.002, 0.003}, {push_x, 0.0, 9.81}};
            sample.a_B.y() += lives ? noise : 0.0;
            REQUIRE(ok(estimator.add_imu(sample)));
        }
    }
    /// Frames at 20 Hz. @return seconds until one has the reason, or infinity
    double fly(double duration_s, bool dark = false) {
        double contradicted_s = INFINITY;
        for (int k = 0; k < std::lround(duration_s / 0.05); ++k) {
            feed(0.05);
            StereoFrame frame = vehicle.frame(kStep_s * count - 0.01, dark);
            frame.right = has_right ? frame.right : ImageView{};
            REQUIRE(ok(estimator.add_frame(frame, estimate)));
            contradicted_s = is_replaced() ? std::min(contradicted_s, 0.05 * (k + 1)) : contradicted_s;
            most_m = std::max(most_m, (estimate.state.p_W_B - before).norm());
        }
        return contradicted_s;
    }
    bool is_replaced() const { return (estimate.health.reasons & kReasonImuContradicted) != 0U; }

    static constexpr double kStep_s = 0.005;
    StillVehicle vehicle;
    Estimator estimator;
    Estimate estimate;
    Eigen::Vector3d before = Eigen::Vector3d::Zero();
    double most_m = 0.0;  ///< away from there, since the last time that this was set
    double push_x = 0.0;  ///< m/s^2 that inertial samples are wrong by
    bool lives = true;
    bool has_right = true;
    int count = 0;
};

}  // namespace

TEST_CASE("an accelerometer that leads astray is suspected before it has led far, however slowly", "[hanging]") {
    const bool lives = GENERATE(true, false);
    const double push = GENERATE(0.5, 1.0, 2.0);
    Flight flight;
    flight.push_x = push;
    flight.lives = lives;
    CAPTURE(lives, push);
    CHECK(flight.fly(1.0) <= 0.3);
    CHECK(flight.most_m < 0.01);
}

TEST_CASE("one camera accuses no reading, since its map has the readings' scale", "[hanging]") {
    const bool has_right = GENERATE(true, false);
    Flight flight;
    flight.has_right = has_right;
    flight.fly(1.0);  // a keyframe
    flight.push_x = 2.0;
    CHECK((flight.fly(0.5) < INFINITY) == has_right);
}

TEST_CASE("a sensor that hangs at what is right is no reason to doubt it", "[hanging]") {
    Flight flight;
    flight.lives = false;
    CHECK(std::isinf(flight.fly(3.0)));
    CHECK(flight.estimate.health.state == TrackingState::kTracking);
}

TEST_CASE("a sensor that hangs is suspected as long as it hangs, and believed soon after", "[hanging]") {
    Flight flight;
    flight.push_x = 4.0;
    flight.lives = false;
    REQUIRE(flight.fly(0.5) <= 0.3);
    for (int k = 0; k < 10; ++k) {
        flight.fly(0.05, true);
        const double error = (flight.estimate.state.p_W_B - flight.before).norm();
        const double sigma = std::sqrt(flight.estimate.covariance.diagonal().segment<3>(kPos).sum());
        CAPTURE(k, error, sigma);
        CHECK(flight.is_replaced());
        CHECK(error < 3.0 * sigma);
    }
    flight.fly(1.0);
    CHECK(flight.is_replaced());
    flight.push_x = 0.0;
    flight.fly(2.5);
    CHECK(flight.is_replaced());  // what is right now is not known as long as it hangs
    flight.lives = true;
    flight.fly(3.5);
    CHECK_FALSE(flight.is_replaced());
}

}  // namespace facet::hanging_sensor_test
