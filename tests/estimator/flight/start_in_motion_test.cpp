// SPDX-License-Identifier: BSD-2-Clause
// Starts of which inertial samples alone do not tell the velocity: with one camera in motion, and after a state that
// has run away.
#include <algorithm>
#include <cmath>

#include "tests/support/still_vehicle.h"

namespace facet::start_in_motion_test {

using facet::test::StillVehicle;

namespace {

/// A vehicle that sways along the wall. Its acceleration is a pixel a frame squared this way, then that way, so that
/// the picture is where it would be, to the last bit, at each frame.
struct Swaying {
    /// @param frames  of half a period, even: its top speed is half as many pixels a frame
    explicit Swaying(int frames) : frames_(frames) {}

    /// At frame k since the beginning: speed in pixels a frame, place in pixels.
    double speed_px(double k) const {
        const double in_period = std::fmod(k, 2.0 * frames_);
        return 0.5 * (1 - frames_) + std::min(in_period, 2.0 * frames_ - in_period);
    }
    int place_px(int k) const {
        int place = kFirst_px;
        for (int i = 0; i < k; ++i) {
            place += static_cast<int>(std::lround(0.5 * (speed_px(i) + speed_px(i + 1))));
        }
        return place;
    }
    Eigen::Vector3d velocity_B() const { return speed_px(seen_) / kFrame_s * vehicle.way_of_pixel_B(); }
    /// The mean of both at an instant when it changes.
    Eigen::Vector3d acceleration_B(int sample) const {
        const double in_turn = std::fmod(sample, 2 * frames_ * kSamples);
        const double sign = in_turn == 0.0 || in_turn == frames_ * kSamples ? 0.0
                            : in_turn < frames_ * kSamples                  ? 1.0
                                                                            : -1.0;
        return sign / (kFrame_s * kFrame_s) * vehicle.way_of_pixel_B();
    }
    /// Frames at 20 Hz, each with inertial samples of two frames beyond it, whatever offset of clocks is estimated.
    /// @return seconds until the first TRACKING or DEGRADED, or infinity
    double fly(double duration_s, bool with_right) {
        double after_s = INFINITY;
        for (int n = 1; n <= std::lround(duration_s / kFrame_s); ++n) {
            seen_ = next_++;
            for (; sample_ <= (seen_ + 2) * kSamples; ++sample_) {
                const Eigen::Vector3d force = acceleration_B(sample_) + 9.81 * up_B;
                REQUIRE(
                    ok(estimator.add_imu({test::at(kFrame_s / kSamples * sample_), {0.001, -0.002, 0.003}, force})));
            }
            StereoFrame frame = vehicle.moved_frame(kFrame_s * seen_, place_px(seen_));
            frame.right = with_right ? frame.right : ImageView{};
            REQUIRE(ok(estimator.add_frame(frame, estimate)));
            const TrackingState state = estimate.health.state;
            if (state == TrackingState::kTracking || state == TrackingState::kDegraded) {
                after_s = std::min(after_s, kFrame_s * n);
            }
        }
        return after_s;
    }
    /// Of the velocity in the body frame, which no yaw turns.
    double error_m_per_s() const {
        return (estimate.state.q_W_B.conjugate() * estimate.state.v_W_B - velocity_B()).norm();
    }
    double sigma_m_per_s() const { return std::sqrt(estimate.covariance.diagonal().segment<3>(6).sum()); }

    StillVehicle vehicle;
    Estimator estimator;
    Estimate estimate;
    const Eigen::Vector3d up_B = Eigen::Vector3d::UnitZ();

private:
    static constexpr double kFrame_s = 0.05;
    static constexpr int kSamples = 10;  ///< inertial, a frame
    static constexpr int kFirst_px = 300;
    int frames_;
    int next_ = 10;  ///< inertial samples begin before the first frame
    int seen_ = 0;
    int sample_ = 0;
};

}  // namespace

TEST_CASE("one camera in motion: no estimate until keyframes give the velocity, which is correct then", "[start]") {
    Swaying flight(12);
    const StereoRig rig = StereoRig::monocular(flight.vehicle.rig.left, flight.vehicle.rig.T_B_C0);
    REQUIRE(ok(flight.estimator.configure({}, rig)));
    const double after_s = flight.fly(4.0, false);
    CAPTURE(after_s, to_string(flight.estimate.health.state), flight.error_m_per_s(), flight.sigma_m_per_s());
    CHECK(after_s > 0.2);
    CHECK(after_s < 4.0);
    CHECK(flight.error_m_per_s() < 3.0 * flight.sigma_m_per_s() + 0.02);
}

TEST_CASE("a right camera that comes during a start with one ends the wait", "[start]") {
    Swaying flight(6);
    REQUIRE(ok(flight.estimator.configure({}, flight.vehicle.rig)));
    CHECK(flight.fly(0.3, false) == INFINITY);
    const double after_s = flight.fly(1.0, true);
    CAPTURE(after_s, to_string(flight.estimate.health.state), flight.error_m_per_s(), flight.sigma_m_per_s());
    CHECK(after_s < 0.5);
    CHECK(flight.error_m_per_s() < 3.0 * flight.sigma_m_per_s() + 0.02);
    CHECK(flight.estimate.health.reset_counter == 0);
}

TEST_CASE("a start with two cameras under 3 m/s^2 tracks within 0.4 s, without a detour", "[start]") {
    // Gravity is 17 degrees off at first, which the map of the first keyframes does not know.
    Swaying flight(16);
    REQUIRE(ok(flight.estimator.configure({}, flight.vehicle.rig)));
    const Estimate& e = flight.estimate;
    double after_s = INFINITY;
    for (int frame = 1; frame <= 20; ++frame) {
        after_s = std::min(after_s, 0.05 * frame - 0.05 + flight.fly(0.05, true));
        CAPTURE(frame, to_string(e.health.state), e.health.reasons);
        CHECK(e.health.state != TrackingState::kLost);
        CHECK(e.health.reset_counter == 0);
    }
    CHECK(after_s < 0.41);
    CHECK(flight.error_m_per_s() < 3.0 * flight.sigma_m_per_s() + 0.02);
}

TEST_CASE("a state that has run away restarts from gravity, where the vehicle was", "[start]") {
    Swaying flight(16);  // up to 1.2 m/s
    EstimatorConfig config;
    config.health.max_speed_m_per_s = 1.0;
    REQUIRE(ok(flight.estimator.configure(config, flight.vehicle.rig)));
    // It runs away again whenever it is fast: looked at where it has had a good start since.
    const Estimate& e = flight.estimate;
    bool has_flown = false;
    bool has_run_away = false;
    int tracked = 0;  // frames in a row since
    for (int frame = 0; frame < 100 && tracked < 5; ++frame) {
        flight.fly(0.05, true);
        has_run_away = has_run_away || (has_flown && e.health.state == TrackingState::kLost);
        has_flown = has_flown || e.health.state == TrackingState::kTracking;
        tracked = has_run_away && e.health.state == TrackingState::kTracking ? tracked + 1 : 0;
    }
    CHECK(tracked == 5);
    CAPTURE(to_string(e.health.state), e.health.reset_counter, flight.error_m_per_s(), e.state.p_W_B.transpose());
    CHECK(e.health.reset_counter > 0);
    CHECK((e.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ() - flight.up_B).norm() < 0.02);
    const Eigen::Vector3d place_sigma = e.covariance.diagonal().segment<3>(3).cwiseSqrt();
    CHECK(e.state.p_W_B.norm() < place_sigma.norm());
    CHECK(place_sigma.norm() > 1.0);  // what may have been flown meanwhile is said
}

}  // namespace facet::start_in_motion_test
