// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/slant_votes.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

#include "platform/base/angle.h"
#include "tests/support/allocation_guard.h"

namespace facet::slant_votes_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kTilt = 3.0 * kRadPerDeg;

Vector3d direction(double tilt_deg, double azimuth_deg) {
    const double t = tilt_deg * kRadPerDeg;
    const double a = azimuth_deg * kRadPerDeg;
    return {std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), std::cos(t)};
}

/// Faces of the plane n . p = d (from the origin of the votes), within 2 m of its foot, turned and shifted by chance.
void vote_plane(SlantVotes& votes, const Vector3d& n, double d, int faces, double turn_sigma, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> uniform(-2.0, 2.0);
    const Vector3d u = n.unitOrthogonal();
    const Vector3d v = n.cross(u);
    for (int i = 0; i < faces; ++i) {
        const Vector3d turned = (n + turn_sigma * (gauss(random) * u + gauss(random) * v)).normalized();
        const Vector3d at = (d + 0.01 * gauss(random)) * n + uniform(random) * u + uniform(random) * v;
        votes.vote(turned.cast<float>(), at.cast<float>(), 0.02F);
    }
}

TEST_CASE("a slanted surface is one peak, whatever its direction") {
    const auto votes = std::make_unique<SlantVotes>();
    const Vector3d origin(100.0, -50.0, 7.0);
    for (const double tilt : {8.0, 20.0, 45.0, 75.0, 100.0, 150.0, 172.0}) {
        for (double azimuth = 0.0; azimuth < 360.0; azimuth += 29.0) {
            const Vector3d n = direction(tilt, azimuth);
            votes->begin(origin, kTilt);
            vote_plane(*votes, n, -1.5, 60, 0.05, 3);
            const auto peaks = votes->find_peaks(0.2F);
            INFO("tilt " << tilt << ", azimuth " << azimuth);
            REQUIRE(peaks.size() == 1);
            CHECK(peaks[0].kind == PlaneKind::kSlanted);
            CHECK(peaks[0].normal_W.dot(n) > std::cos(2.0 * kRadPerDeg));
            CHECK(peaks[0].distance_m - peaks[0].normal_W.dot(origin) == Approx(-1.5).margin(0.05));
            CHECK(peaks[0].support_m2 > 0.6F);  // of 1.2
        }
    }
}

TEST_CASE("parallel surfaces and the two sides of a roof are peaks of their own; floors, walls and clutter are none") {
    const auto votes = std::make_unique<SlantVotes>();
    votes->begin(Vector3d::Zero(), kTilt);
    vote_plane(*votes, direction(30.0, 0.0), -1.0, 60, 0.05, 1);
    vote_plane(*votes, direction(30.0, 0.0), -2.0, 40, 0.05, 2);
    vote_plane(*votes, direction(30.0, 180.0), -1.0, 50, 0.05, 3);
    vote_plane(*votes, direction(1.0, 0.0), -1.0, 200, 0.03, 4);
    vote_plane(*votes, direction(90.5, 70.0), -1.0, 200, 0.03, 5);
    std::mt19937 random(6);
    std::normal_distribution<float> gauss;
    for (int i = 0; i < 200; ++i) {
        votes->vote(Vector3f(gauss(random), gauss(random), gauss(random)).normalized(),
                    Vector3f(gauss(random), gauss(random), gauss(random)), 0.01F);
    }
    const auto peaks = votes->find_peaks(0.25F);
    REQUIRE(peaks.size() == 3);
    int first = 0;
    int second = 0;
    int other = 0;
    for (const PlanePeak& peak : peaks) {
        const bool is_here = peak.normal_W.dot(direction(30.0, 0.0)) > std::cos(4.0 * kRadPerDeg);
        first += is_here && std::abs(peak.distance_m + 1.0) < 0.1 ? 1 : 0;
        second += is_here && std::abs(peak.distance_m + 2.0) < 0.1 ? 1 : 0;
        other += peak.normal_W.dot(direction(30.0, 180.0)) > std::cos(4.0 * kRadPerDeg) ? 1 : 0;
    }
    CHECK(first == 1);
    CHECK(second == 1);
    CHECK(other == 1);
    votes->begin(Vector3d::Zero(), kTilt);
    CHECK(votes->find_peaks(0.01F).empty());
}

TEST_CASE("more slanted surfaces than there is room for: some of them, and nothing is allocated") {
    const auto votes = std::make_unique<SlantVotes>();
    votes->begin(Vector3d::Zero(), kTilt);
    for (int i = 0; i < 8; ++i) {
        vote_plane(*votes, direction(40.0, 45.0 * i), -1.0, 40, 0.03, static_cast<unsigned>(i));
    }
    const test::AllocationGuard guard;
    for (int i = 0; i < 2 * kMaxMeshFaces; ++i) {
        votes->vote(Vector3f::UnitX(), Vector3f::Zero(), 1e-9F);
    }
    const auto peaks = votes->find_peaks(0.2F);
    CHECK(guard.allocations() == 0);
    CHECK(peaks.size() == SlantVotes::kMaxPeaks);
}

}  // namespace
}  // namespace facet::slant_votes_test
