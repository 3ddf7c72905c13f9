// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/imu_checks.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "app/support/rng.h"

namespace facet::imu_checks_test {
namespace {

constexpr double kRateHz = 200.0;

struct Recording {
    double seconds = 5.0;
    double unit = 1.0;      ///< the accelerometer's readings are multiplied by it
    double gravity = 9.81;  ///< m/s^2
    double noise_factor = 1.0;
    bool moves = false;
};

/// A level vehicle, at rest or shaken slowly.
std::vector<ImuSample> record(const Recording& r) {
    const ImuNoise noise;
    RandomStream random(5, 1);
    const double per_sample = r.noise_factor * std::sqrt(kRateHz);
    const auto three = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
    std::vector<ImuSample> samples;
    for (int i = 0; i < static_cast<int>(r.seconds * kRateHz); ++i) {
        const double t = i / kRateHz;
        ImuSample s;
        s.stamp = Timestamp{} + Duration::from_seconds(t);
        s.w_B = per_sample * noise.gyro_noise_rad_per_s_per_sqrt_hz * three();
        s.a_B = Eigen::Vector3d(0.0, 0.0, r.gravity) + per_sample * noise.accel_noise_m_per_s2_per_sqrt_hz * three();
        if (r.moves) {
            s.w_B.z() += 0.5 * std::sin(3.0 * t);
            s.a_B.x() += std::sin(5.0 * t);
        }
        s.a_B *= r.unit;
        samples.push_back(s);
    }
    return samples;
}

CheckVerdict gravity_of(const Recording& r) {
    const std::vector<ImuSample> samples = record(r);
    return check_gravity(samples, find_rests(samples));
}

TEST_CASE("a vehicle at rest shows gravity, and noise as the file says") {
    const std::vector<ImuSample> samples = record({});
    const std::vector<RestStretch> rests = find_rests(samples);
    CHECK(rests.size() == 5);
    CHECK(check_gravity(samples, rests).level == CheckLevel::kOk);
    CHECK(check_imu_rate(samples, ImuNoise{}).level == CheckLevel::kOk);
    const CheckVerdict noise = check_imu_noise(samples, rests, ImuNoise{});
    CHECK(noise.level == CheckLevel::kOk);
    for (const auto& [name, ratio] : noise.figures) {
        CHECK(ratio == Approx(1.0).epsilon(0.1));
    }
}

TEST_CASE("gravity in motion is judged by the mean magnitude") {
    const std::vector<ImuSample> samples = record({.moves = true});
    CHECK(find_rests(samples).empty());
    CHECK(check_gravity(samples, {}).level == CheckLevel::kOk);
}

TEST_CASE("readings in g, without gravity, and of a wrong scale are wrong, each in its own words") {
    const CheckVerdict in_g = gravity_of({.unit = 1.0 / 9.81});
    CHECK(in_g.level == CheckLevel::kWrong);
    CHECK(in_g.sentence.find("in g") != std::string::npos);
    const CheckVerdict none = gravity_of({.gravity = 0.0});
    CHECK(none.level == CheckLevel::kWrong);
    CHECK(none.sentence.find("taken out") != std::string::npos);
    CHECK(gravity_of({.unit = 2.0}).level == CheckLevel::kWrong);
    CHECK(gravity_of({.unit = 1.05}).level == CheckLevel::kSuspicious);
}

TEST_CASE("noise far above the file's is suspicious, and without rest nobody can tell") {
    const std::vector<ImuSample> noisy = record({.noise_factor = 5.0});
    CHECK(check_imu_noise(noisy, find_rests(noisy), ImuNoise{}).level == CheckLevel::kSuspicious);
    const std::vector<ImuSample> moving = record({.moves = true});
    CHECK(check_imu_noise(moving, find_rests(moving), ImuNoise{}).level == CheckLevel::kCannotTell);
}

TEST_CASE("the rate is compared with the file's") {
    ImuNoise noise;
    noise.rate_hz = 400.0;
    CHECK(check_imu_rate(record({}), noise).level == CheckLevel::kWrong);
    noise.rate_hz = 220.0;
    CHECK(check_imu_rate(record({}), noise).level == CheckLevel::kSuspicious);
    CHECK(check_imu_rate({}, noise).level == CheckLevel::kWrong);
}

}  // namespace
}  // namespace facet::imu_checks_test
