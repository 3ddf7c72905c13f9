// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/health_monitor.h"

#include <catch2/catch.hpp>

namespace facet::health_monitor_test {
namespace {

Timestamp at(double t) { return Timestamp{} + Duration::from_seconds(100.0 + t); }

/// A frame on which all is well.
HealthEvidence good(double t) {
    HealthEvidence e;
    e.stamp = at(t);
    e.is_started = e.frame_taken = e.has_right = true;
    e.tracked = 200;
    e.stereo = 150;
    e.newest_landmarks = 150;
    e.velocity_sigma_m_per_s = 0.01;
    e.tilt_sigma_rad = 0.002;
    e.vision_chi2 = 0.8;
    return e;
}

struct Fixture {
    HealthMonitor monitor;
    Health health;
    Fixture() {
        monitor.configure({});
        monitor.reset();
        monitor.restart(at(0.0), true);
    }
    TrackingState step(const HealthEvidence& e) {
        monitor.update(e, health);
        return health.state;
    }
    bool has(HealthReason reason) const { return (health.reasons & reason) != 0U; }
};

HealthEvidence dark(double t) {
    HealthEvidence e = good(t);
    e.image = ImageState::kDark;
    e.tracked = e.stereo = 0;
    return e;
}

}  // namespace

TEST_CASE("before data there is INIT without reasons", "[health]") {
    HealthMonitor monitor;
    monitor.configure({});
    monitor.reset();
    Health health;
    monitor.update({}, health);
    CHECK(health.state == TrackingState::kInit);
    CHECK(health.reasons == 0U);
    CHECK(health.quality == 0);
}

TEST_CASE("a start in motion is INIT until velocity and gravity are known at a keyframe", "[health]") {
    Fixture f;
    f.monitor.restart(at(0.0), false);
    HealthEvidence e = good(0.2);
    e.is_keyframe = e.is_optimized = true;
    e.velocity_sigma_m_per_s = 0.4;
    CHECK(f.step(e) == TrackingState::kInit);
    CHECK(f.health.quality == 0);
    e = good(0.4);
    CHECK(f.step(e) == TrackingState::kInit);  // no keyframe
    e.is_keyframe = e.is_optimized = true;
    e.vision_chi2 = 6.0;
    CHECK(f.step(e) == TrackingState::kInit);  // the window has not come together yet
    e.vision_chi2 = 0.8;
    CHECK(f.step(e) == TrackingState::kTracking);
}

TEST_CASE("quality is low after a start, then full", "[health]") {
    Fixture f;
    CHECK(f.step(good(0.5)) == TrackingState::kTracking);
    CHECK(f.health.quality == 30);
    f.step(good(2.5));
    CHECK(f.health.quality == 100);
}

TEST_CASE("images of two cameras that never match are worth half, until they do", "[health]") {
    Fixture f;
    HealthEvidence e = good(2.5);
    e.is_keyframe = e.is_optimized = true;
    e.stereo = 3;  // as exchanged cameras show by chance
    CHECK(f.step(e) == TrackingState::kTracking);
    CHECK(f.has(kReasonFewStereo));
    CHECK(f.health.quality == 50);
    f.step(good(2.55));  // between keyframes stereo is not looked for
    CHECK(f.health.quality == 50);
    e.stamp = at(3.0);
    e.stereo = 100;
    f.step(e);
    CHECK(f.health.quality == 100);
    e.stamp = at(3.5);
    e.stereo = 3;  // far away, or one image is dark
    f.step(e);
    CHECK(f.health.quality == 100);
}

TEST_CASE("one camera alone owes no stereo", "[health]") {
    Fixture f;
    HealthEvidence e = good(2.5);
    e.is_keyframe = e.is_optimized = true;
    e.has_right = false;
    e.stereo = 0;
    f.step(e);
    CHECK(f.health.quality == 100);
}

TEST_CASE("darkness degrades at once, loses after the limit, and only a restart ends that", "[health]") {
    Fixture f;
    f.step(good(3.0));
    CHECK(f.step(dark(3.05)) == TrackingState::kDegraded);
    CHECK(f.has(kReasonImageDark));
    const int first = f.health.quality;
    CHECK(f.step(dark(5.9)) == TrackingState::kDegraded);
    CHECK(f.health.quality < first);
    CHECK(f.step(dark(6.1)) == TrackingState::kLost);
    CHECK(f.health.quality == 0);
    CHECK_FALSE(f.monitor.has_diverged());
    HealthEvidence e = good(6.2);
    e.is_keyframe = e.is_optimized = true;
    CHECK(f.step(e) == TrackingState::kLost);  // a window that inertial samples do not connect
    f.monitor.restart(at(6.3), false);
    e.stamp = at(6.6);
    CHECK(f.step(e) == TrackingState::kTracking);
}

TEST_CASE("a lost window that has held is back as soon as a keyframe is as sure as a start", "[health]") {
    HealthConfig config;
    config.auto_reset = GENERATE(true, false);
    Fixture f;
    f.monitor.configure(config);
    f.step(good(3.0));
    f.step(dark(5.9));
    REQUIRE(f.step(dark(6.1)) == TrackingState::kLost);
    CHECK_FALSE(f.monitor.needs_restart());
    HealthEvidence e = good(6.2);
    e.is_unbroken = true;
    CHECK(f.step(e) == TrackingState::kLost);  // no keyframe yet
    e.is_keyframe = e.is_optimized = true;
    e.velocity_sigma_m_per_s = 0.3;
    CHECK(f.step(e) == TrackingState::kLost);
    e.velocity_sigma_m_per_s = 0.05;
    e.vision_chi2 = 6.0;
    CHECK(f.step(e) == TrackingState::kLost);
    e.vision_chi2 = 1.0;
    CHECK(f.step(e) == (config.auto_reset ? TrackingState::kTracking : TrackingState::kLost));
}

TEST_CASE("a lost window whose keyframes stay unsure needs a restart, and so does one that has diverged", "[health]") {
    Fixture f;
    f.step(good(3.0));
    SECTION("unsure") {
        f.step(dark(5.9));
        REQUIRE(f.step(dark(6.1)) == TrackingState::kLost);
        HealthEvidence e = good(6.2);
        e.is_unbroken = e.is_keyframe = e.is_optimized = true;
        e.velocity_sigma_m_per_s = 0.3;
        for (int k = 0; k < HealthMonitor::kFruitlessKeyframes; ++k) {
            CHECK_FALSE(f.monitor.needs_restart());
            CHECK(f.step(e) == TrackingState::kLost);
        }
    }
    SECTION("samples missing") {
        HealthEvidence e = dark(4.0);
        e.imu.has_gap = true;
        f.step(e);
        CHECK(f.step(dark(6.1)) == TrackingState::kLost);
        e = good(6.2);
        e.is_unbroken = e.is_keyframe = e.is_optimized = true;
        CHECK(f.step(e) == TrackingState::kLost);
    }
    SECTION("diverged") {
        HealthEvidence e = good(3.1);
        e.is_unbroken = e.is_keyframe = e.is_optimized = true;
        e.speed_m_per_s = 30.0;
        CHECK(f.step(e) == TrackingState::kLost);
        e.speed_m_per_s = 1.0;
        CHECK(f.step(e) == TrackingState::kLost);
    }
    CHECK(f.monitor.needs_restart());
    f.monitor.restart(at(7.0), false);
    CHECK_FALSE(f.monitor.needs_restart());
}

TEST_CASE("samples missing while vision held are forgotten by the time it is lost", "[health]") {
    Fixture f;
    HealthEvidence e = good(3.0);
    e.imu.has_gap = true;
    f.step(e);
    f.step(good(3.1));
    f.step(dark(5.0));
    REQUIRE(f.step(dark(6.2)) == TrackingState::kLost);
    CHECK_FALSE(f.monitor.needs_restart());
}

TEST_CASE("between frames that do not come nothing is said of images", "[health]") {
    Fixture f;
    HealthEvidence e = good(0.5);
    e.has_frame = e.frame_taken = e.has_right = false;
    e.lacks_right = true;
    e.tracked = e.stereo = 0;
    CHECK(f.step(e) == TrackingState::kDegraded);
    CHECK(f.health.reasons == kReasonNoImages);
    e.stamp = at(3.2);
    CHECK(f.step(e) == TrackingState::kLost);
    CHECK(f.step(good(3.3)) == TrackingState::kLost);
}

TEST_CASE("a camera that is silent for good degrades, with a reason of its own", "[health]") {
    Fixture f;
    HealthEvidence e = good(3.0);
    e.misses_camera = true;
    CHECK(f.step(e) == TrackingState::kDegraded);
    CHECK(f.has(kReasonOneCamera));
    CHECK(f.step(good(3.1)) == TrackingState::kTracking);
}

TEST_CASE("frames by the cameras' own stamps degrade, with a reason of their own", "[health]") {
    Fixture f;
    HealthEvidence e = good(3.0);
    e.is_by_stamps = true;
    CHECK(f.step(e) == TrackingState::kDegraded);
    CHECK(f.has(kReasonTriggerSilent));
    CHECK(f.step(good(3.1)) == TrackingState::kTracking);
}

TEST_CASE("a start with one camera waits for its second opinion", "[health]") {
    Fixture f;
    f.monitor.restart(at(0.0), false);
    HealthEvidence e = good(1.0);
    e.is_keyframe = e.is_optimized = true;
    e.is_confirmed = false;
    CHECK(f.step(e) == TrackingState::kInit);
    e.is_confirmed = true;
    CHECK(f.step(e) == TrackingState::kTracking);
}

TEST_CASE("light within the limit ends degradation", "[health]") {
    Fixture f;
    f.step(good(3.0));
    f.step(dark(4.0));
    CHECK(f.step(good(4.1)) == TrackingState::kTracking);
    CHECK(f.health.reasons == 0U);
}

TEST_CASE("each sign of divergence loses the estimate by itself", "[health]") {
    Fixture f;
    HealthEvidence e = good(3.0);
    SECTION("speed") { e.speed_m_per_s = 30.0; }
    SECTION("gyroscope bias") { e.gyro_bias_rad_per_s = 1.0; }
    SECTION("accelerometer bias") { e.accel_bias_m_per_s2 = 5.0; }
    SECTION("not a number") { e.is_finite = false; }
    CHECK(f.step(e) == TrackingState::kLost);
    CHECK(f.monitor.has_diverged());
}

TEST_CASE("residuals must be wrong at three keyframes in a row", "[health]") {
    Fixture f;
    HealthEvidence e = good(3.0);
    e.is_keyframe = e.is_optimized = true;
    e.vision_chi2 = 40.0;
    CHECK(f.step(e) == TrackingState::kDegraded);
    CHECK(f.step(e) == TrackingState::kDegraded);
    e.vision_chi2 = 1.0;
    CHECK(f.step(e) == TrackingState::kTracking);
    e.vision_chi2 = 40.0;
    f.step(e);
    f.step(e);
    CHECK(f.step(e) == TrackingState::kLost);
}

TEST_CASE("an unsure velocity degrades, a very unsure one loses after a second, without divergence", "[health]") {
    Fixture f;
    HealthEvidence e = good(3.0);
    e.velocity_sigma_m_per_s = 0.7;
    CHECK(f.step(e) == TrackingState::kDegraded);
    CHECK(f.has(kReasonVelocityUncertain));
    e = good(4.0);
    f.step(e);
    e.velocity_sigma_m_per_s = 1.1;
    CHECK(f.step(e) == TrackingState::kDegraded);
    e.stamp = at(4.9);
    CHECK(f.step(e) == TrackingState::kDegraded);
    e.stamp = at(5.1);
    CHECK(f.step(e) == TrackingState::kLost);
    CHECK_FALSE(f.monitor.has_diverged());
}

TEST_CASE("things worth a word that leave tracking be", "[health]") {
    Fixture f;
    HealthEvidence e = good(3.0);
    e.has_right = false;
    e.lacks_right = true;
    CHECK(f.step(e) == TrackingState::kTracking);
    CHECK(f.has(kReasonNoRightImage));
    e = good(3.1);
    e.imu.accel_vibration_m_per_s2 = 5.0;
    CHECK(f.step(e) == TrackingState::kTracking);
    CHECK(f.has(kReasonVibration));
}

TEST_CASE("clipped or missing inertial samples degrade", "[health]") {
    Fixture f;
    HealthEvidence e = good(3.0);
    e.imu.clipped = 0x08;
    CHECK(f.step(e) == TrackingState::kDegraded);
    CHECK(f.has(kReasonImuClipped));
    e = good(3.1);
    e.imu.has_gap = true;
    CHECK(f.step(e) == TrackingState::kDegraded);
    CHECK(f.has(kReasonImuGap));
}

TEST_CASE("a calibration in doubt halves the quality, and does not end tracking", "[health]") {
    Fixture f;
    HealthEvidence e = good(10.0);
    e.residual_bias_px = 0.014;
    e.calibration_stretch = 3.9;
    CHECK(f.step(e) == TrackingState::kTracking);
    CHECK_FALSE(f.has(kReasonCalibration));
    CHECK(f.health.quality == 100);

    e.stamp = at(10.05);
    e.residual_bias_px = 0.0151;
    CHECK(f.step(e) == TrackingState::kTracking);
    CHECK(f.has(kReasonCalibration));
    CHECK(f.health.quality == 50);

    e.stamp = at(10.1);
    e.residual_bias_px = 0.075;
    f.step(e);
    CHECK(f.health.quality == 20);

    e.stamp = at(10.15);
    e.residual_bias_px = 0.0;
    e.calibration_stretch = 5.0;
    f.step(e);
    CHECK(f.has(kReasonCalibration));
    CHECK(f.health.quality == 50);
}

TEST_CASE("inertial readings that images contradict degrade, and halve the quality at least", "[health]") {
    Fixture f;
    HealthEvidence e = good(10.0);
    e.imu_chi2 = 3.9;
    CHECK(f.step(e) == TrackingState::kTracking);
    CHECK(f.health.quality == 100);

    e.stamp = at(10.05);
    e.imu.is_replaced = true;
    CHECK(f.step(e) == TrackingState::kDegraded);
    CHECK(f.has(kReasonImuContradicted));
    CHECK(f.health.quality == 50);

    e.stamp = at(10.1);
    e.imu.is_replaced = false;
    e.imu_chi2 = 16.0;
    CHECK(f.step(e) == TrackingState::kDegraded);
    CHECK(f.has(kReasonHighResidual));
    CHECK_FALSE(f.has(kReasonImuContradicted));
    CHECK(f.health.quality == 25);
}

}  // namespace facet::health_monitor_test
