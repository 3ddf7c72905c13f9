// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/vision_noise.h"

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace facet::vision_noise_test {
namespace {

/// Residuals of this deviation, all in the loss's core: an observation's weight is that of a mean.
void show(VisionNoise& noise, double px, int rows = 500) {
    const double whitened = px / noise.sigma_px();
    const double squared = whitened * whitened * rows;
    noise.measure(px * px * rows, rows, 0.7 * px, {rows / 2, squared, 0.5 * rows, 0.5 * rows, squared});
}

const double kRootDependence = std::sqrt(VisionNoise::kDependence);

/// Points about the origin: a narrow core, and one in five ten times as wide.
std::vector<Eigen::Vector2d> heavy_tails(int count, std::mt19937& random) {
    std::normal_distribution<double> normal;
    std::bernoulli_distribution wide(0.2);
    std::vector<Eigen::Vector2d> points(static_cast<std::size_t>(count));
    for (Eigen::Vector2d& p : points) {
        const double deviation = wide(random) ? 1.0 : 0.1;
        p = {deviation * normal(random), deviation * normal(random)};
    }
    return points;
}

/// The place that minimises Cauchy's loss.
Eigen::Vector2d robust_mean(const std::vector<Eigen::Vector2d>& points, const RobustLoss& loss, LossSums& sums) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (int iteration = 0; iteration < 30; ++iteration) {
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        sums = {};
        for (const Eigen::Vector2d& p : points) {
            const double s = (p - mean).squaredNorm();
            const double w = loss.weight(s);
            sum += w * (p - mean);
            sums += {1, s, w, loss.slope(s), w * w * s};
        }
        mean += sum / sums.weight;
    }
    return mean;
}

VisionNoise learned(double configured_px, double shown_px, int keyframes) {
    VisionNoise noise;
    noise.reset(configured_px, true);
    for (int k = 0; k < keyframes; ++k) {
        show(noise, shown_px);
        noise.learn();
    }
    return noise;
}

}  // namespace

TEST_CASE("scale and weights follow what residuals show", "[window]") {
    CHECK(learned(0.5, 0.3, 0).sigma_px() == 0.5);
    CHECK(learned(0.5, 0.3, 100).sigma_px() == Approx(0.3 * kRootDependence).epsilon(1e-3));
    CHECK(learned(0.5, 0.3, 100).scale_px() == Approx(0.7 * 0.3).epsilon(1e-3));
    CHECK(learned(0.5, 0.3, 100).measured_px() == Approx(0.3));
    // A mean of variances at first, with the configured one as one of them.
    CHECK(std::pow(learned(0.5, 0.8, 3).scale_px(), 2) == Approx((0.25 + 3 * 0.49 * 0.64) / 4));
}

TEST_CASE("the variance that weights stand for is the one that robust means have", "[window]") {
    // Independent points, so what the normal equations claim must be kDependence times the truth.
    constexpr int kPoints = 200;
    constexpr int kMeans = 4000;
    std::mt19937 random(3);
    const RobustLoss loss{0.45, LossKind::kCauchy};  // the points' root mean square
    double scatter = 0.0;
    double claimed = 0.0;
    for (int i = 0; i < kMeans; ++i) {
        LossSums sums;
        scatter += 0.5 * robust_mean(heavy_tails(kPoints, random), loss, sums).squaredNorm() / kMeans;
        VisionNoise noise;
        noise.reset(1.0, true);
        noise.measure(sums.squared_error, 2 * kPoints - 2, 1.0, sums);
        for (int k = 0; k < 200; ++k) {
            noise.learn();
        }
        claimed += noise.sigma_px() * noise.sigma_px() / sums.weight / kMeans;
    }
    CHECK(claimed / VisionNoise::kDependence == Approx(scatter).epsilon(0.05));
    // The mean itself scatters five times as much.
    CHECK(0.208 / kPoints > 4.0 * scatter);
}

TEST_CASE("weights stay within reach of the configured ones", "[window]") {
    CHECK(learned(0.5, 0.01, 200).sigma_px() == Approx(0.05).epsilon(1e-3));
    CHECK(learned(0.5, 30.0, 200).sigma_px() == Approx(5.0).epsilon(1e-3));
}

TEST_CASE("too few residuals, or none that are numbers, teach nothing", "[window]") {
    VisionNoise noise;
    noise.reset(0.5, true);
    show(noise, 0.1, VisionNoise::kEnoughRows - 1);
    show(noise, std::numeric_limits<double>::quiet_NaN());
    CHECK(noise.measured_px() == 0.5);
    noise.learn();
    CHECK(noise.sigma_px() == Approx(0.5));
    CHECK(noise.scale_px() == Approx(0.5));
}

TEST_CASE("a configured sigma that is not to be learned stays", "[window]") {
    VisionNoise noise;
    noise.reset(0.5, false);
    show(noise, 1.0);
    noise.learn();
    CHECK(noise.sigma_px() == 0.5);
    CHECK(noise.measured_px() == Approx(1.0));
    CHECK(noise.cautious_px() == 0.5);
}

}  // namespace facet::vision_noise_test
