// SPDX-License-Identifier: BSD-2-Clause
// What may happen to images without ending the estimator: none for longer than the inertial history, one camera dead,
// one camera only.
#include <algorithm>
#include <cmath>

#include "tests/support/still_vehicle.h"

namespace facet::outage_test {

using facet::test::StillVehicle;

namespace {

/// A vehicle at rest whose estimator is fed in real time.
struct Flight {
    explicit Flight(double imu_rate_hz = 200.0) : vehicle(imu_rate_hz) {
        config.imu_noise.rate_hz = imu_rate_hz;
        REQUIRE(ok(estimator.configure(config, vehicle.rig)));
    }

    /// Inertial samples only. @return the states reported, newest last
    std::vector<Estimate> wait(double duration_s) {
        std::vector<Estimate> reports;
        for (int k = 0; k < std::lround(duration_s / 0.01); ++k) {
            feed(0.01);
            Estimate carried;
            if (ok(estimator.take_carried(carried))) {
                reports.push_back(carried);
            }
        }
        return reports;
    }
    /// Frames at 20 Hz, edited by `edit`. @return seconds until the first TRACKING, or infinity
    template <class Edit>
    double fly(double duration_s, Edit edit) {
        double tracking_after_s = INFINITY;
        for (int k = 0; k < std::lround(duration_s / 0.05); ++k) {
            feed(0.05);
            StereoFrame frame = vehicle.frame(now_s - 0.01);
            edit(frame);
            REQUIRE(ok(estimator.add_frame(frame, estimate)));
            if (estimate.health.state == TrackingState::kTracking) {
                tracking_after_s = std::min(tracking_after_s, 0.05 * (k + 1));
            }
        }
        return tracking_after_s;
    }
    double fly(double duration_s) {
        return fly(duration_s, [](StereoFrame&) {});
    }
    /// Half a second of inertial samples, then frames at rest.
    void begin(double duration_s) {
        feed(0.5);
        fly(duration_s);
    }
    void feed(double duration_s) {
        vehicle.feed_imu(estimator, now_s, now_s + duration_s, push_x);
        now_s += duration_s;
    }
    bool has(HealthReason reason) const { return (estimate.health.reasons & reason) != 0U; }

    StillVehicle vehicle;
    EstimatorConfig config;
    Estimator estimator;
    Estimate estimate;
    double now_s = 0.0;
    double push_x = 0.0;  ///< m/s^2 that inertial samples are wrong by
};

}  // namespace

TEST_CASE("frames away for longer than the inertial history: lost, said so, and back", "[outage]") {
    const auto [rate_hz, away_s] = GENERATE(table<double, double>({{200.0, 25.0}, {1000.0, 6.0}}));
    CAPTURE(rate_hz, away_s);
    Flight flight(rate_hz);
    flight.begin(1.5);
    REQUIRE(flight.estimate.health.state == TrackingState::kTracking);
    const Estimate before = flight.estimate;

    const std::vector<Estimate> reports = flight.wait(away_s);
    REQUIRE(reports.size() >= static_cast<std::size_t>(5.0 * away_s));
    for (const Estimate& e : reports) {
        const double away = (e.stamp - before.stamp).seconds();
        CHECK(e.health.state == (away > 3.0 ? TrackingState::kLost : TrackingState::kDegraded));
        CHECK((e.health.reasons & kReasonNoImages) != 0U);
        CHECK(e.health.reset_counter == 0);
    }
    for (int i = 3; i < 6; ++i) {
        CHECK(reports.back().covariance(i, i) > before.covariance(i, i));
    }

    CHECK(flight.fly(1.5) <= 1.0);
    CHECK(flight.estimate.health.reset_counter == 1);
    const Eigen::Vector3d error = flight.estimate.state.p_W_B - before.state.p_W_B;
    CHECK(error.norm() < 0.05);  // it stood all the while, and the IMU has seen nothing else
    for (int i = 0; i < 3; ++i) {
        CHECK(std::abs(error[i]) < 3.0 * std::sqrt(flight.estimate.covariance(3 + i, 3 + i)));
    }
}

TEST_CASE("a window that restarts knows its velocity within a few frames, though nothing moves", "[outage]") {
    Flight flight;
    flight.begin(1.5);
    flight.wait(3.5);
    flight.push_x = 0.3;
    flight.wait(0.5);
    flight.push_x = 0.0;
    const std::vector<Estimate> reports = flight.wait(0.5);
    REQUIRE(reports.back().health.state == TrackingState::kLost);
    REQUIRE(reports.back().state.v_W_B.norm() > 0.1);
    flight.fly(0.05);
    const Eigen::Vector3d back = flight.estimate.state.p_W_B;
    flight.fly(0.3);
    CHECK(flight.estimate.health.reset_counter == 1);
    CHECK(flight.estimate.state.v_W_B.norm() < 0.01);
    CHECK((flight.estimate.state.p_W_B - back).norm() < 0.02);
}

TEST_CASE("after darkness the window goes on where inertial samples still connect it", "[outage]") {
    const auto [dark_s, goes_on] = GENERATE(table<double, bool>({{4.0, true}, {25.0, false}}));
    CAPTURE(dark_s);
    Flight flight;
    flight.begin(12.0);
    const int keyframes = flight.estimate.health.keyframes;
    flight.fly(dark_s, [&flight](StereoFrame& frame) { frame = flight.vehicle.frame(flight.now_s - 0.01, true); });
    REQUIRE(flight.estimate.health.state == TrackingState::kLost);
    CHECK(flight.estimate.health.reset_counter == 0);
    CHECK(flight.fly(0.5) <= 0.5);
    CHECK(flight.estimate.health.reset_counter == 1);  // the place may leap either way
    CAPTURE(keyframes, flight.estimate.health.keyframes);
    CHECK((flight.estimate.health.keyframes >= keyframes) == goes_on);
    CHECK(flight.estimate.state.p_W_B.norm() < 0.05);
}

TEST_CASE("a frame later than what was carried on without it is refused, the next ones are waited for", "[outage]") {
    Flight flight;
    flight.begin(1.0);
    flight.wait(2.0);
    int refused = 0;
    for (int k = 0; k < 40; ++k) {
        flight.feed(0.05);
        refused += ok(flight.estimator.add_frame(flight.vehicle.frame(flight.now_s - 0.6), flight.estimate)) ? 0 : 1;
    }
    CHECK(refused > 0);
    CHECK(refused < 15);
    CHECK(flight.estimate.health.state == TrackingState::kTracking);
}

TEST_CASE("an inertial clock that goes back has lost time: the window restarts, and says so", "[outage]") {
    Flight flight;
    flight.begin(1.5);
    const Estimate before = flight.estimate;
    // Other readings at stamps that there have been: half a second of time is on no clock.
    for (int k = 0; k < 100; ++k) {
        const Timestamp stamp = facet::test::at(flight.now_s - 0.5 + 0.005 * k);
        CHECK(flight.estimator.add_imu({stamp, {0.1, 0.0, 0.0}, {0.0, 0.0, 9.9}}) == Status::kOutOfOrder);
    }
    flight.fly(1.5);
    CHECK(flight.estimate.health.state == TrackingState::kTracking);
    CHECK(flight.estimate.health.reset_counter == before.health.reset_counter + 1);
    CHECK(flight.estimate.state.p_W_B.norm() < 0.05);
}

TEST_CASE("samples and frames that come twice have lost no time", "[outage]") {
    Flight flight;
    flight.begin(1.5);
    for (int k = 0; k < 100; ++k) {
        const Timestamp stamp = facet::test::at(flight.now_s - 0.5 + 0.005 * k);
        CHECK(flight.estimator.add_imu({stamp, {0.001, -0.002, 0.003}, {0.0, 0.0, 9.81}}) == Status::kOutOfOrder);
    }
    for (int k = 0; k < 3; ++k) {
        Estimate none;
        CHECK(flight.estimator.add_frame(flight.vehicle.frame(flight.now_s - 0.01), none) == Status::kOutOfOrder);
    }
    const double place_variance = flight.estimate.covariance(3, 3);
    flight.fly(1.0);
    CHECK(flight.estimate.health.reset_counter == 0);
    CHECK(flight.estimate.covariance(3, 3) < 1.5 * place_variance);
}

TEST_CASE("the right camera takes over when the left one dies, and both work again when it returns", "[outage]") {
    Flight flight;
    flight.begin(1.5);
    const auto no_left = [](StereoFrame& frame) { frame.left = {}; };
    flight.fly(0.2, no_left);
    CHECK_FALSE(flight.estimate.health.is_exchanged);  // a few lost images are no reason
    CHECK(flight.estimate.health.state == TrackingState::kDegraded);
    flight.fly(2.0, no_left);
    CHECK(flight.estimate.health.is_exchanged);
    CHECK(flight.estimate.health.state == TrackingState::kDegraded);
    CHECK(flight.has(kReasonOneCamera));
    CHECK(flight.estimate.health.tracked > 50);
    CHECK(flight.estimate.health.reset_counter == 1);
    CHECK(flight.estimate.state.p_W_B.norm() < 0.05);
    CHECK(flight.fly(1.0) < 0.3);
    CHECK(flight.estimate.health.is_exchanged);
    CHECK(flight.estimate.health.reset_counter == 1);  // stereo in the same window
    CHECK_FALSE(flight.has(kReasonOneCamera));
    CHECK(flight.estimate.state.p_W_B.norm() < 0.05);
}

TEST_CASE("with one camera dead a lost estimate comes back", "[outage]") {
    const bool left = GENERATE(true, false);
    CAPTURE(left);
    Flight flight;
    flight.begin(1.5);
    const auto one = [left](StereoFrame& frame) { (left ? frame.right : frame.left) = {}; };
    flight.fly(1.5, one);
    CHECK(flight.estimate.health.state == TrackingState::kDegraded);
    CHECK(flight.wait(6.0).back().health.state == TrackingState::kLost);
    flight.fly(1.0, one);
    CHECK(flight.estimate.health.state == TrackingState::kDegraded);
    CHECK(flight.has(kReasonOneCamera));
    CHECK(flight.estimate.state.p_W_B.norm() < 0.05);
}

TEST_CASE("a vehicle with one camera is tracked, and nothing is missing", "[outage]") {
    Flight flight;
    const StereoRig rig = StereoRig::monocular(flight.vehicle.rig.left, flight.vehicle.rig.T_B_C0);
    REQUIRE(ok(flight.estimator.configure(flight.config, rig)));
    flight.feed(0.5);
    flight.fly(3.0, [](StereoFrame& frame) { frame.right = {}; });
    CHECK(flight.estimate.health.state == TrackingState::kTracking);
    CHECK(flight.estimate.health.reasons == 0U);
    CHECK(flight.estimate.state.p_W_B.norm() < 0.02);
}

TEST_CASE("stamps near the ends of their range are refused, all others work", "[outage]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    const std::int64_t end = std::numeric_limits<std::int64_t>::max();
    for (const std::int64_t ns : {end, end - 1000, -end, -end - 1}) {
        CHECK(estimator.add_imu({{ns}, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}}) == Status::kInvalidArgument);
        StereoFrame frame = vehicle.frame(0.5);
        frame.stamp.ns = ns;
        Estimate estimate;
        CHECK(estimator.add_frame(frame, estimate) == Status::kInvalidArgument);
    }
    vehicle.feed_imu(estimator, 0.0, 1.0);
    Estimate estimate;
    CHECK(ok(estimator.add_frame(vehicle.frame(0.5), estimate)));
}

TEST_CASE("an accelerometer that goes wrong at rest is suspected, though keyframes are rare there", "[outage]") {
    Flight flight;
    flight.begin(2.5);
    const Estimate before = flight.estimate;
    flight.push_x = 8.0;
    for (int k = 0; k < 20; ++k) {
        flight.fly(0.05);
        const double error = (flight.estimate.state.p_W_B - before.state.p_W_B).norm();
        CHECK(error < 0.01);
        CHECK((k == 0 || flight.has(kReasonImuContradicted)));
    }
}

TEST_CASE("an accelerometer that is right again is believed again, and nothing is left of it", "[outage]") {
    Flight flight;
    flight.begin(2.5);
    const Estimate before = flight.estimate;
    flight.push_x = 8.0;
    flight.fly(1.0);
    flight.push_x = 0.0;
    CHECK(flight.fly(6.0) < 5.0);  // two keyframes, which are rare at rest
    CHECK_FALSE(flight.has(kReasonImuContradicted));
    const NavState& after = flight.estimate.state;
    CAPTURE(after.p_W_B.transpose(), after.bias.accel.transpose(), flight.estimate.health.reset_counter);
    CHECK((after.p_W_B - before.state.p_W_B).norm() < 0.02);
    CHECK((after.bias.accel - before.state.bias.accel).norm() < 0.05);
    const Eigen::Vector3d up_B = after.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    CHECK(up_B.head<2>().norm() < 0.01);
}

TEST_CASE("suspected readings are all there is when the images go, and as uncertain as they were found", "[outage]") {
    Flight flight;
    flight.begin(2.5);
    const Eigen::Vector3d before = flight.estimate.state.p_W_B;
    flight.push_x = 8.0;
    flight.fly(0.5);
    REQUIRE(flight.has(kReasonImuContradicted));
    for (int k = 0; k < 6; ++k) {
        flight.fly(0.05, [&flight](StereoFrame& frame) { frame = flight.vehicle.frame(flight.now_s - 0.01, true); });
        const double error = (flight.estimate.state.p_W_B - before).norm();
        const double sigma = std::sqrt(flight.estimate.covariance.diagonal().segment<3>(kPos).sum());
        CAPTURE(k, error, sigma);
        CHECK(error < 3.0 * sigma);
    }
}

}  // namespace facet::outage_test
