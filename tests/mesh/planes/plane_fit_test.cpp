// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_fit.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "mesh/planes/plane_config.h"

namespace facet::plane_fit_test {
namespace {

using Eigen::Vector3d;

constexpr double kFlat = 0.002;

std::vector<std::uint16_t> all_of(const std::vector<PlanePoint>& points) {
    std::vector<std::uint16_t> which(points.size());
    std::iota(which.begin(), which.end(), std::uint16_t{0});
    return which;
}

/// Points on a tilted plane around `centre`, with noise of this standard deviation in all directions.
std::vector<PlanePoint> sample(const Vector3d& n, const Vector3d& centre, int count, double noise, std::mt19937& random,
                               double bend = 0.0) {
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::normal_distribution<double> gauss(0.0, noise);
    const Vector3d a = n.unitOrthogonal();
    const Vector3d b = n.cross(a);
    std::vector<PlanePoint> points;
    for (int i = 0; i < count; ++i) {
        const double u = 1.5 * uniform(random);
        const double v = 0.6 * uniform(random);
        PlanePoint p;
        p.p_W = centre + u * a + v * b + bend * u * u * n + Vector3d(gauss(random), gauss(random), gauss(random));
        p.covariance_W = static_cast<float>(noise * noise) * Eigen::Matrix3f::Identity();
        points.push_back(p);
    }
    return points;
}

TEST_CASE("a plane is recovered, far from the world's origin too, and its reported uncertainty is honest") {
    std::mt19937 random(1);
    const Vector3d n = Vector3d(0.9, -0.3, 0.1).normalized();
    const Vector3d centre(4000.0, -2000.0, 30.0);
    double offset_nees = 0.0;
    double turn_nees = 0.0;
    int bent = 0;
    constexpr int kRuns = 300;
    for (int run = 0; run < kRuns; ++run) {
        const auto points = sample(n, centre, 60, 0.03, random);
        PlaneFit fit;
        fit.normal_W = (n + Vector3d(0.0, 0.1, -0.05)).normalized();
        fit.distance_m = fit.normal_W.dot(centre) + 0.05;
        REQUIRE(ok(fit_plane(points, all_of(points), kFlat, fit)));
        REQUIRE(std::abs(fit.normal_W.norm() - 1.0) < 1e-12);
        REQUIRE(fit.normal_W.dot(n) > 0.999);
        bent += fit.bend_m > 0.0 ? 1 : 0;
        offset_nees +=
            std::pow(fit.residual(centre + (fit.centroid_W - centre) - n * n.dot(fit.centroid_W - centre)), 2) /
            std::pow(fit.sigma_m, 2);
        turn_nees += std::pow(fit.along_W.dot(n) / fit.sigma_along_rad, 2) +
                     std::pow(fit.across_W.dot(n) / fit.sigma_across_rad, 2);
    }
    CHECK(bent <= 3);  // one in a thousand is expected
    CHECK(offset_nees / kRuns == Approx(1.0).margin(0.3));
    CHECK(turn_nees / kRuns == Approx(2.0).margin(0.5));
}

TEST_CASE("uncertain and outlying points hardly move a plane") {
    std::mt19937 random(2);
    auto points = sample(Vector3d::UnitZ(), {1.0, 2.0, 0.5}, 80, 0.01, random);
    for (std::size_t i = 0; i < 20; ++i) {  // a fifth is far off, and says so
        points[i].p_W.z() += 0.3;
        points[i].covariance_W *= 400.0F;
    }
    for (std::size_t i = 20; i < 26; ++i) {  // and some do not say so
        points[i].p_W.z() += 0.1;
    }
    PlaneFit fit;
    fit.distance_m = 0.5;
    REQUIRE(ok(fit_plane(points, all_of(points), kFlat, fit)));
    CHECK(std::abs(fit.residual({1.0, 2.0, 0.5})) < 0.01);
    CHECK(fit.normal_W.z() > std::cos(0.02));
}

TEST_CASE("too few points and points on a line are refused, and leave the plane as it was") {
    std::mt19937 random(3);
    auto points = sample(Vector3d::UnitZ(), Vector3d::Zero(), 40, 0.01, random);
    PlaneFit fit;
    fit.distance_m = 0.125;
    const std::vector<std::uint16_t> few{0, 1, 2, 3, 4};
    CHECK(fit_plane(points, few, kFlat, fit) == Status::kDegenerate);
    for (PlanePoint& p : points) {
        p.p_W.y() = 0.01 * p.p_W.x();
    }
    CHECK(fit_plane(points, all_of(points), kFlat, fit) == Status::kDegenerate);
    CHECK(describe_plane(points, all_of(points), kFlat, fit) == Status::kDegenerate);
    CHECK(fit.distance_m == 0.125);
    CHECK(fit.points == 0);
}

TEST_CASE("a bent surface is distinguished from a flat one with the same noise") {
    std::mt19937 random(4);
    PlaneFit flat;
    const auto straight = sample(Vector3d::UnitX(), Vector3d::Zero(), 100, 0.02, random);
    flat.normal_W = Vector3d::UnitX();
    PlaneFit bent = flat;
    REQUIRE(ok(fit_plane(straight, all_of(straight), kFlat, flat)));
    const auto curved = sample(Vector3d::UnitX(), Vector3d::Zero(), 100, 0.02, random, 0.05);
    REQUIRE(ok(fit_plane(curved, all_of(curved), kFlat, bent)));
    CHECK(flat.bend_m == 0.0);
    // 0.05 (u^2 - mean) over u in +-1.5 has rms 0.05 * 1.5^2 * sqrt(4 / 45).
    CHECK(bent.bend_m == Approx(0.05 * 2.25 * std::sqrt(4.0 / 45.0)).epsilon(0.25));
}

TEST_CASE("describing a plane leaves normal and distance alone and sees how badly it fits") {
    std::mt19937 random(5);
    const auto points = sample(Vector3d::UnitZ(), Vector3d::Zero(), 60, 0.01, random);
    PlaneFit fit;
    fit.distance_m = 0.05;
    REQUIRE(ok(describe_plane(points, all_of(points), kFlat, fit)));
    CHECK(fit.distance_m == 0.05);
    CHECK(fit.chi2 > 15.0);
    CHECK(std::abs(fit.residual(fit.centroid_W)) < 1e-12);
}

TEST_CASE("plane parameters out of range are refused") {
    CHECK(ok(PlaneConfig{}.validate()));
    PlaneConfig config;
    config.min_area_m2 = 0.0;
    CHECK(config.validate() == Status::kInvalidArgument);
    config = {};
    config.surface_sigma_m = std::nan("");
    CHECK(config.validate() == Status::kInvalidArgument);
}

TEST_CASE("sums taken in blocks are those of a plain loop, whatever the number of points") {
    std::mt19937 random(17);
    std::normal_distribution<float> gauss;
    const Vector3d n = Vector3d(0.1, 0.2, 1.0).normalized();
    for (const int count : {6, 7, 31, 32, 33, 63, 64, 65, 200}) {
        auto points = sample(n, {20.0, -30.0, 1.0}, count, 0.02, random);
        for (PlanePoint& p : points) {
            const Eigen::Matrix3f a = 0.02F * Eigen::Matrix3f::NullaryExpr([&] { return gauss(random); });
            p.covariance_W = a * a.transpose();
        }
        PlaneFit fit;
        fit.normal_W = (n + Vector3d(0.01, 0.0, 0.0)).normalized();
        fit.distance_m = fit.normal_W.dot(Vector3d(20.0, -30.0, 1.02));
        double squared = 0.0;
        double weights = 0.0;
        Vector3d mean = Vector3d::Zero();
        for (const PlanePoint& p : points) {
            const double variance = p.variance_along(fit.normal_W.cast<float>()) + kFlat * kFlat;
            const double off = std::abs(fit.residual(p.p_W)) / std::sqrt(variance);
            const double weight = (off <= 1.5 ? 1.0 : 1.5 / off) / variance;
            squared += off * off;
            weights += weight;
            mean += weight * p.p_W;
        }
        mean /= weights;
        REQUIRE(ok(describe_plane(points, all_of(points), kFlat, fit, PlaneBend::kLeave)));
        INFO(count << " points");
        CHECK(fit.chi2 == Approx(squared / (count - 3.0)).epsilon(1e-9));
        CHECK(fit.sigma_m == Approx(std::sqrt(std::max(1.0, fit.chi2) / weights)).epsilon(1e-9));
        CHECK((fit.centroid_W - (mean - fit.residual(mean) * fit.normal_W)).norm() < 1e-9);
        CHECK(fit.bend_m == 0.0);  // not asked for
        PlaneFit asked = fit;
        REQUIRE(ok(describe_plane(points, all_of(points), kFlat, asked)));
        CHECK(asked.bend_m == bend_of(points, all_of(points), kFlat, fit));
    }
}

}  // namespace
}  // namespace facet::plane_fit_test
