// SPDX-License-Identifier: BSD-2-Clause
// The facade's contract: order, readiness, bad images, blindness, missing inertial data. Accuracy is tests/scenario's.
#include "estimator/api/estimator.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "tests/support/still_vehicle.h"

namespace facet::estimator_test {

using facet::test::StillVehicle;

TEST_CASE("a still vehicle is tracked as soon as a second image confirms it, and stays where it is", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    vehicle.feed_imu(estimator, 0.0, 4.0);
    Estimate estimate;
    double time_offset_s = 0.0;
    for (double t = 0.5; t < 3.9; t += 0.05) {
        REQUIRE(ok(estimator.add_frame(vehicle.frame(t), estimate)));
        CHECK(estimate.health.state == (t < 0.51 ? TrackingState::kInit : TrackingState::kTracking));
        CHECK(estimate.stamp == test::at(t) + Duration::from_seconds(time_offset_s));
        time_offset_s = estimate.health.time_offset_s;
        CHECK(std::abs(time_offset_s) < 1e-6);  // nothing moves, so nothing tells the offset
    }
    CHECK(estimate.state.p_W_B.norm() < 0.01);
    CHECK(estimate.state.v_W_B.norm() < 0.01);
    CHECK((estimate.state.bias.gyro - Eigen::Vector3d(0.001, -0.002, 0.003)).norm() < 1e-4);
    CHECK(estimate.health.is_still);
}

TEST_CASE("frames wait for inertial samples and must come in order", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    Estimate estimate;
    CHECK(estimator.add_frame(vehicle.frame(0.0), estimate) == Status::kNotReady);
    vehicle.feed_imu(estimator, 0.0, 0.6);
    CHECK(estimator.add_frame(vehicle.frame(0.9), estimate) == Status::kNotReady);
    REQUIRE(ok(estimator.add_frame(vehicle.frame(0.5), estimate)));
    CHECK(estimator.add_frame(vehicle.frame(0.5), estimate) == Status::kOutOfOrder);
    CHECK(estimator.add_frame(vehicle.frame(0.4), estimate) == Status::kOutOfOrder);
    vehicle.feed_imu(estimator, 0.6, 1.0);
    CHECK(ok(estimator.add_frame(vehicle.frame(0.9), estimate)));
}

TEST_CASE("too little inertial data before the first frame means INIT, not an error", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    vehicle.feed_imu(estimator, 0.0, 1.0);
    Estimate estimate;
    REQUIRE(ok(estimator.add_frame(vehicle.frame(0.02), estimate)));
    CHECK(estimate.health.state == TrackingState::kInit);
    REQUIRE(ok(estimator.add_frame(vehicle.frame(0.5), estimate)));
    REQUIRE(ok(estimator.add_frame(vehicle.frame(0.55), estimate)));
    CHECK(estimate.health.state == TrackingState::kTracking);
}

TEST_CASE("the view of a keyframe is filled on demand, and estimates do not depend on it", "[estimator]") {
    const StillVehicle vehicle;
    Estimator asked;
    Estimator plain;
    REQUIRE(ok(asked.configure({}, vehicle.rig)));
    REQUIRE(ok(plain.configure({}, vehicle.rig)));
    vehicle.feed_imu(asked, 0.0, 2.1);
    vehicle.feed_imu(plain, 0.0, 2.1);
    Estimate a;
    Estimate b;
    bool is_after_keyframe = false;
    for (int k = 0; k < 30; ++k) {
        const StereoFrame frame = vehicle.moved_frame(0.5 + 0.05 * k, 4 * k);
        REQUIRE(ok(asked.add_frame(frame, a)));
        REQUIRE(ok(plain.add_frame(frame, b)));
        const std::uint32_t before = asked.keyframe_view().number;
        asked.finish_frame();
        const std::uint32_t number = asked.keyframe_view().number;
        asked.finish_frame();  // once
        CHECK(asked.keyframe_view().number == number);
        CHECK((number == before || a.health.is_keyframe || is_after_keyframe));
        is_after_keyframe = a.health.is_keyframe;
        CHECK(a.state.q_W_B.coeffs() == b.state.q_W_B.coeffs());
        CHECK(a.state.p_W_B == b.state.p_W_B);
        CHECK(a.covariance == b.covariance);
    }
    CHECK(asked.keyframe_view().number > 3);
    CHECK_FALSE(asked.keyframe_view().landmarks.empty());
    CHECK_FALSE(asked.keyframe_view().surface.empty());
}

TEST_CASE("a glide at constant speed, which the IMU takes for rest, starts as the motion that it is", "[estimator]") {
    const int step_px = GENERATE(1, 4, 8);  // 0.14 to 1.1 m/s
    CAPTURE(step_px);
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    vehicle.feed_imu(estimator, 0.0, 3.1);
    const Eigen::Vector3d v_W = 20.0 * step_px * vehicle.way_of_pixel_B();  // begins level, its yaw zero
    Estimate estimate;
    double tracking_after_s = INFINITY;
    for (int k = 0; k < 50; ++k) {
        REQUIRE(ok(estimator.add_frame(vehicle.moved_frame(0.5 + 0.05 * k, step_px * k), estimate)));
        if (estimate.health.state == TrackingState::kTracking || estimate.health.state == TrackingState::kDegraded) {
            tracking_after_s = std::min(tracking_after_s, 0.05 * k);
            const Eigen::Vector3d error = estimate.state.v_W_B - v_W;
            const double sigma = std::sqrt(estimate.covariance.diagonal().segment<3>(6).sum());
            CHECK(error.norm() < 3.0 * sigma + 0.02);
        }
    }
    CHECK(tracking_after_s < 1.0);
    CHECK(estimate.health.reset_counter == 0);
    CHECK((estimate.state.v_W_B - v_W).norm() < 0.05);
}

TEST_CASE("a vehicle that stands starts once, though its gyroscope drifts", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    vehicle.feed_imu(estimator, 0.0, 0.5);
    for (int k = 0; k < 600; ++k) {  // by 0.9 px in half a second, as the images do not
        REQUIRE(ok(estimator.add_imu({test::at(0.5 + 0.005 * k), {0.001, -0.002, 0.007}, {0.0, 0.0, 9.81}})));
    }
    Estimate estimate;
    for (int k = 0; k < 50; ++k) {
        REQUIRE(ok(estimator.add_frame(vehicle.frame(0.45 + 0.05 * k), estimate)));
        CHECK(estimate.health.reset_counter == 0);
    }
    CHECK(estimate.health.state == TrackingState::kTracking);
    CHECK(estimate.state.p_W_B.norm() < 0.01);
}

TEST_CASE("a vehicle that stands with idling rotors begins level, and stays where it is", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    // Narrow bands, as rotors have them, of which the images show nothing.
    const auto shake = [](double t) {
        return ImuSample{test::at(t),
                         {0.001 + 0.045 * std::sin(110.0 * t), -0.002, 0.003 + 0.02 * std::sin(79.0 * t + 1.0)},
                         {0.7 * std::sin(107.0 * t), 0.4 * std::sin(94.0 * t + 0.5), 9.81 + 0.3 * std::sin(300.0 * t)}};
    };
    for (int k = 0; k < 620; ++k) {
        REQUIRE(ok(estimator.add_imu(shake(0.005 * k))));
    }
    Estimate first;
    Estimate estimate;
    double first_s = INFINITY;
    for (int k = 0; k < 58; ++k) {
        REQUIRE(ok(estimator.add_frame(vehicle.frame(0.1 + 0.05 * k), estimate)));
        if (estimate.health.state == TrackingState::kInit) {
            continue;
        }
        if (first_s == INFINITY) {
            first = estimate;
            first_s = 0.05 * k;
            const Eigen::Vector3d up_B = first.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
            CHECK(up_B.head<2>().norm() < 1.7e-3);
        }
        CHECK(estimate.health.state == TrackingState::kTracking);
        CHECK((estimate.state.p_W_B - first.state.p_W_B).norm() < 1.5e-3);
        // Half a degree: the gyroscope's ripple bends what the first keyframes, a tenth of a second apart, know of it.
        CHECK(so3_log(first.state.q_W_B.conjugate() * estimate.state.q_W_B).norm() < 9e-3);
        CHECK((estimate.state.bias.gyro - Eigen::Vector3d(0.001, -0.002, 0.003)).norm() < 6e-3);
    }
    CHECK(first_s < 0.41);
    CHECK(estimate.health.reset_counter == 0);
}

TEST_CASE("bad inertial samples are dropped and counted", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    vehicle.feed_imu(estimator, 0.0, 1.0);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(estimator.add_imu({test::at(1.0), {nan, 0.0, 0.0}, {0.0, 0.0, 9.81}}) == Status::kInvalidArgument);
    CHECK(estimator.add_imu({test::at(0.5), {0.0, 0.0, 0.0}, {0.0, 0.0, 9.81}}) == Status::kOutOfOrder);
    Estimate estimate;
    REQUIRE(ok(estimator.add_frame(vehicle.frame(0.8), estimate)));
    CHECK(estimate.health.imu_dropped == 2);
    CHECK(estimate.state.p_W_B.allFinite());
}

TEST_CASE("darkness degrades, then loses; light brings vision back", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    vehicle.feed_imu(estimator, 0.0, 6.5);
    Estimate estimate;
    const auto fly = [&](double t0, double t1, bool dark) {
        for (double t = t0; t < t1 - 1e-9; t += 0.05) {
            REQUIRE(ok(estimator.add_frame(vehicle.frame(t, dark), estimate)));
            REQUIRE(estimate.state.p_W_B.allFinite());
        }
    };
    fly(0.5, 2.0, false);
    fly(2.0, 3.0, true);
    CHECK(estimate.health.state == TrackingState::kDegraded);
    CHECK((estimate.health.reasons & kReasonFewFeatures) != 0U);
    CHECK(estimate.state.p_W_B.norm() < 0.2);
    CHECK((estimate.health.reasons & kReasonImageDark) != 0U);
    const double place_sigma = std::sqrt(estimate.covariance(4, 4));
    const double yaw_before = 2.0 * estimate.state.q_W_B.z();
    fly(3.0, 5.2, true);
    CHECK(estimate.health.state == TrackingState::kLost);
    CHECK(estimate.health.quality == 0);
    CHECK(estimate.health.reset_counter == 0);
    CHECK(std::sqrt(estimate.covariance(4, 4)) > 2.0 * place_sigma);
    fly(5.2, 6.4, false);
    CHECK(estimate.health.state == TrackingState::kTracking);
    CHECK(estimate.health.reset_counter == 1);
    CHECK(std::abs(2.0 * estimate.state.q_W_B.z() - yaw_before) < 0.01);
}

TEST_CASE("a second of darkness is bridged: landmarks are found again, nothing is reset", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    vehicle.feed_imu(estimator, 0.0, 5.0);
    Estimate estimate;
    int recalled = 0;
    for (int k = 0; k < 80; ++k) {
        const double t = 0.5 + 0.05 * k;
        const bool dark = k >= 40 && k < 60;
        REQUIRE(ok(estimator.add_frame(vehicle.frame(t, dark), estimate)));
        const TrackingState seen = k == 0 ? TrackingState::kInit : TrackingState::kTracking;
        CHECK(estimate.health.state == (dark ? TrackingState::kDegraded : seen));
        recalled += estimate.health.recalled;
    }
    CHECK(recalled > 100);
    CHECK(estimate.health.reset_counter == 0);
    CHECK(estimate.state.p_W_B.norm() < 0.01);
}

TEST_CASE("a reset on request keeps place and attitude and raises the counter", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    estimator.request_reset();  // nothing to reset yet
    vehicle.feed_imu(estimator, 0.0, 4.0);
    Estimate estimate;
    for (int k = 0; k < 60; ++k) {
        if (k == 30) {
            estimator.request_reset();
        }
        REQUIRE(ok(estimator.add_frame(vehicle.frame(0.5 + 0.05 * k), estimate)));
        CHECK(estimate.health.reset_counter == (k < 30 ? 0U : 1U));
    }
    CHECK(estimate.health.state == TrackingState::kTracking);
    CHECK(estimate.state.p_W_B.norm() < 0.01);
}

TEST_CASE("a wrong image size is refused, the estimate goes on by inertial data", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    REQUIRE(ok(estimator.configure({}, vehicle.rig)));
    vehicle.feed_imu(estimator, 0.0, 2.0);
    Estimate estimate;
    REQUIRE(ok(estimator.add_frame(vehicle.frame(0.5), estimate)));
    REQUIRE(ok(estimator.add_frame(vehicle.frame(0.55), estimate)));
    StereoFrame small = vehicle.frame(0.6);
    small.left.width = 640;
    CHECK(estimator.add_frame(small, estimate) == Status::kInvalidArgument);
    CHECK(estimate.stamp == small.stamp);
    CHECK((estimate.health.reasons & kReasonImageRejected) != 0U);
    CHECK(estimate.health.state == TrackingState::kDegraded);
    REQUIRE(ok(estimator.add_frame(vehicle.frame(0.65), estimate)));
    CHECK(estimate.health.state == TrackingState::kTracking);
}

TEST_CASE("stereo matches survive a principal point that is given wrong", "[estimator]") {
    StillVehicle vehicle;
    CameraIntrinsics wrong = vehicle.rig.right.intrinsics();
    wrong.cy += 2.3;  // beyond the limit on the epipolar distance
    vehicle.rig.right = CameraModel(wrong);
    EstimatorConfig config;
    config.calibration.estimate_cameras = GENERATE(true, false);
    Estimator estimator;
    REQUIRE(ok(estimator.configure(config, vehicle.rig)));
    vehicle.feed_imu(estimator, 0.0, 4.0);
    Estimate estimate;
    int keyframes = 0;
    for (double t = 0.5; t < 3.9; t += 0.05) {
        REQUIRE(ok(estimator.add_frame(vehicle.frame(t), estimate)));
        if (estimate.health.is_keyframe) {
            ++keyframes;
            CAPTURE(t, config.calibration.estimate_cameras);
            CHECK((estimate.health.stereo > 0.8 * estimate.health.tracked) == config.calibration.estimate_cameras);
        }
    }
    CHECK(keyframes > 3);
}

TEST_CASE("configurations out of range are refused", "[estimator]") {
    const StillVehicle vehicle;
    Estimator estimator;
    EstimatorConfig config;
    config.window.keyframes = 99;
    CHECK(estimator.configure(config, vehicle.rig) == Status::kInvalidArgument);
    config = {};
    config.imu_noise.rate_hz = std::numeric_limits<double>::quiet_NaN();
    CHECK(estimator.configure(config, vehicle.rig) == Status::kInvalidArgument);
    CHECK(estimator.configure({}, StereoRig{}) == Status::kInvalidArgument);
}

TEST_CASE("after an overrun less is begun up to the next keyframe, and health says so", "[estimator]") {
    const StillVehicle vehicle;
    EstimatorConfig config;
    config.frontend.max_features = 60;
    const auto detected_at_start = [&](bool is_late) {
        Estimator estimator;
        REQUIRE(ok(estimator.configure(config, vehicle.rig)));
        vehicle.feed_imu(estimator, 0.0, 3.0);
        if (is_late) {
            estimator.report_overrun();
        }
        Estimate estimate;
        REQUIRE(ok(estimator.add_frame(vehicle.frame(0.5), estimate)));
        REQUIRE(estimate.health.is_keyframe);
        CHECK(((estimate.health.reasons & kReasonOverrun) != 0U) == is_late);
        const int detected = estimate.health.detected;
        REQUIRE(ok(estimator.add_frame(vehicle.frame(0.55), estimate)));
        CHECK((estimate.health.reasons & kReasonOverrun) == 0U);  // the keyframe has paid for it
        estimator.report_overrun();
        REQUIRE(ok(estimator.add_frame(vehicle.frame(0.6), estimate)));
        REQUIRE_FALSE(estimate.health.is_keyframe);
        CHECK((estimate.health.reasons & kReasonOverrun) != 0U);
        CHECK(estimate.health.state == TrackingState::kTracking);
        return detected;
    };
    CHECK(detected_at_start(false) == 60);
    CHECK(detected_at_start(true) == 40);
}

}  // namespace facet::estimator_test
