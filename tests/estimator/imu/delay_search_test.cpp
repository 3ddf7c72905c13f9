// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/delay_search.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace facet::delay_search_test {
namespace {

const Eigen::Vector3d kBias(0.02, -0.01, 0.03);  // rad/s

/// Integral of a lively rate.
Eigen::Vector3d angle(double s) {
    return {0.10 * std::sin(3.0 * s), 0.08 * std::cos(2.3 * s + 1.0), 0.15 * std::sin(1.7 * s + 0.4)};
}

Eigen::Vector3d livelier_angle(double s) { return angle(3.0 * s); }

Timestamp at(double s) { return Timestamp{1'000'000'000} + Duration::from_seconds(s); }

/// Samples that are biased, at this rate, up to some seconds.
void fill(ImuBuffer& imu, double rate_hz, double seconds, Eigen::Vector3d (*angle_at)(double) = angle) {
    imu.clear(rate_hz, {});
    for (int i = 0; i <= static_cast<int>(rate_hz * seconds); ++i) {
        const double s = i / rate_hz;
        constexpr double kHalf = 1e-4;
        const Eigen::Vector3d rate = (angle_at(s + kHalf) - angle_at(s - kHalf)) / (2.0 * kHalf);
        REQUIRE(ok(imu.push({at(s), rate + kBias, {0.0, 0.0, 9.81}})));
    }
}

constexpr double kSigma_rad = 1e-4;

/// Turns from image to image, whose stamps are late by `late_s`: stamps minus that are the IMU's time.
DelaySearch turns(double period_s, double seconds, double late_s, double noise_rad,
                  Eigen::Vector3d (*angle_at)(double) = angle) {
    DelaySearch search;
    search.configure(kSigma_rad);
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0.0, noise_rad);
    for (double s = 0.3; s + period_s < seconds; s += period_s) {
        const Eigen::Vector3d noise(normal(random), normal(random), normal(random));
        search.add(at(s + late_s), at(s + period_s + late_s), angle_at(s + period_s) - angle_at(s) + noise);
    }
    return search;
}

TEST_CASE("a delay of images is found with its sigma, whatever the rates", "[imu]") {
    const double late_s = GENERATE(0.0, 0.0123, 0.051, -0.034, 0.07);
    const double rate_hz = GENERATE(100.0, 1000.0);
    const double period_s = GENERATE(1.0 / 60.0, 0.05, 0.1);
    CAPTURE(late_s, rate_hz, period_s);
    ImuBuffer imu;
    fill(imu, rate_hz, 4.0);
    DelayFit fit;
    const double believed_s = GENERATE(0.0, -0.02);
    REQUIRE(turns(period_s, 3.5, late_s, kSigma_rad).solve(imu, believed_s, fit) == Status::kOk);
    CHECK(fit.delay.sigma_s > 0.0);
    CHECK(fit.delay.sigma_s < 2e-3);
    const double off_s = std::abs(fit.delay.value_s + late_s);
    CHECK(off_s < std::max(4.0 * fit.delay.sigma_s, 5e-4));
    const double wrong_s = std::abs(believed_s + late_s);
    CHECK((fit.gain > 25.0) == (wrong_s > 5.0 * fit.delay.sigma_s));
    CHECK((wrong_s < 5e-4 ? fit.misfit < 2.0 : wrong_s < 0.02 || fit.misfit > 2.0));
}

TEST_CASE("a fifth of a second shows that a delay is wrong, and soon after which one is right", "[imu]") {
    const double late_s = GENERATE(0.0, 0.05, -0.03);
    const double now_s = 0.3 + 4 * 0.05;
    CAPTURE(late_s);
    ImuBuffer imu;
    fill(imu, 200.0, now_s + late_s, livelier_angle);
    DelayFit fit;
    CHECK(turns(0.05, now_s + 0.01, late_s, kSigma_rad, livelier_angle).solve(imu, 0.0, fit) != Status::kNotFound);
    CHECK((fit.misfit > 5.0) == (late_s != 0.0));
    CHECK((fit.gain > 5.0) == (late_s != 0.0));

    const double later_s = 0.3 + 10 * 0.05;
    fill(imu, 200.0, later_s + late_s, livelier_angle);  // no sample is newer than the newest image
    REQUIRE(turns(0.05, later_s + 0.01, late_s, kSigma_rad, livelier_angle).solve(imu, 0.0, fit) == Status::kOk);
    CHECK(fit.delay.value_s == Approx(-late_s).margin(std::max(4.0 * fit.delay.sigma_s, 1e-3)));
}

TEST_CASE("vibration that images do not show is no sign of a delay", "[imu]") {
    constexpr double kShake = 0.15;  // rad/s
    ImuBuffer imu;
    imu.clear(200.0, {});
    std::mt19937 random(3);
    std::normal_distribution<double> normal(0.0, kShake);
    for (int i = 0; i <= 100; ++i) {
        const Eigen::Vector3d shake(normal(random), normal(random), normal(random));
        const Eigen::Vector3d rate = (angle(i / 200.0 + 1e-4) - angle(i / 200.0 - 1e-4)) / 2e-4;
        REQUIRE(ok(imu.push({at(i / 200.0), rate + shake, {0.0, 0.0, 9.81}})));
    }
    DelayFit fit;
    CHECK(turns(0.05, 0.51, 0.0, kSigma_rad).solve(imu, 0.0, fit) != Status::kOk);
    CHECK(fit.misfit > 0.0);
    CHECK(fit.misfit < 3.0);
    CHECK(fit.gain < 5.0);
}

TEST_CASE("what does not show the delay is not taken for one", "[imu]") {
    ImuBuffer imu;
    fill(imu, 200.0, 4.0);
    DelayFit fit;
    SECTION("few turns") { CHECK(turns(0.05, 0.41, 0.02, 2e-4).solve(imu, 0.0, fit) == Status::kNotReady); }
    SECTION("no sample yet") {
        ImuBuffer empty;
        empty.clear(200.0, {});
        DelaySearch search = turns(0.05, 3.5, 0.02, 2e-4);
        CHECK(search.solve(empty, 0.0, fit) == Status::kNotReady);
    }
    SECTION("a vehicle that stands, or turns steadily") {
        const double rate = GENERATE(0.0, 0.5);
        DelaySearch search;
        search.configure(kSigma_rad);
        imu.clear(200.0, {});
        for (int i = 0; i <= 800; ++i) {
            REQUIRE(ok(imu.push({at(i / 200.0), {0.0, 0.0, rate}, {0.0, 0.0, 9.81}})));
        }
        for (int k = 6; k < 70; ++k) {
            const double wiggle = 1e-4 * (k % 2);
            search.add(at(0.05 * k), at(0.05 * (k + 1)), {wiggle, 0.0, 0.05 * rate});
        }
        CHECK(search.solve(imu, 0.0, fit) == Status::kNotReady);
    }
    SECTION("beyond the range") { CHECK_FALSE(ok(turns(0.05, 3.5, 0.2, 2e-4).solve(imu, 0.0, fit))); }
    SECTION("images of something else") { CHECK_FALSE(ok(turns(0.05, 3.5, 0.02, 0.1).solve(imu, 0.0, fit))); }
    SECTION("a hole in the samples") {
        imu.clear(200.0, {});
        for (int i = 0; i <= 800; ++i) {
            if (i < 300 || i > 330) {
                REQUIRE(ok(imu.push({at(i / 200.0), angle(i / 200.0), {0.0, 0.0, 9.81}})));
            }
        }
        CHECK(turns(0.05, 3.5, 0.02, 2e-4).solve(imu, 0.0, fit) == Status::kNotReady);
    }
}

TEST_CASE("turns that do not follow each other begin a new series", "[imu]") {
    DelaySearch search;
    for (int k = 0; k < 400; ++k) {
        search.add(at(0.01 * k), at(0.01 * (k + 1)), Eigen::Vector3d::Zero());
    }
    CHECK(search.size() == DelaySearch::kCapacity);
    search.reset();
    for (int k = 0; k < 100; ++k) {
        search.add(at(0.05 * k), at(0.05 * (k + 1)), Eigen::Vector3d::Zero());
    }
    CHECK(search.size() == static_cast<std::size_t>(DelaySearch::kSpan_s / 0.05));
    search.add(at(4.95), at(5.05), Eigen::Vector3d::Zero());  // overlaps the last one
    CHECK(search.size() == static_cast<std::size_t>(DelaySearch::kSpan_s / 0.05));
    search.add(at(6.0), at(6.05), Eigen::Vector3d::Zero());
    CHECK(search.size() == 1);
    search.add(at(6.05), at(6.05), Eigen::Vector3d::Zero());
    CHECK(search.size() == 0);
    search.add(at(6.05), at(6.1), Eigen::Vector3d::Constant(std::nan("")));
    CHECK(search.size() == 0);
}

}  // namespace
}  // namespace facet::delay_search_test
