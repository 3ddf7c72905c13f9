// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_votes.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "tests/support/allocation_guard.h"

namespace facet::plane_votes_test {
namespace {

using Eigen::Vector3d;

/// Faces of a wall n . p = d, their normals off by this much, votes of `area` each.
void vote_wall(PlaneVotes& votes, double azimuth, double d, double along, double turn_sigma, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss(0.0, turn_sigma);
    std::uniform_real_distribution<double> uniform(-along, along);
    const Vector3d n(std::cos(azimuth), std::sin(azimuth), 0.0);
    const Vector3d t(-std::sin(azimuth), std::cos(azimuth), 0.0);
    for (int i = 0; i < 60; ++i) {
        const double a = azimuth + gauss(random);
        const Eigen::Vector3f normal(static_cast<float>(std::cos(a)), static_cast<float>(std::sin(a)), 0.05F);
        votes.vote_upright(normal, static_cast<float>(turn_sigma), d * n + uniform(random) * t, 0.02F, 0.02F);
    }
}

TEST_CASE("a wall seen from far beside the foot of its perpendicular is one peak, also where azimuth wraps") {
    const auto votes = std::make_unique<PlaneVotes>();
    for (const double azimuth : {0.0, 0.01, -0.01, 1.0, std::numbers::pi, 4.5}) {
        votes->begin(Vector3d::Zero());
        vote_wall(*votes, azimuth, -2.5, 3.0, 0.12, 3);
        const auto peaks = votes->find_peaks(0.3F);
        REQUIRE(peaks.size() >= 1);
        CHECK(peaks[0].kind == PlaneKind::kVertical);
        CHECK(peaks[0].normal_W.dot(Vector3d(std::cos(azimuth), std::sin(azimuth), 0.0)) > std::cos(0.06));
        CHECK(peaks[0].distance_m == Approx(-2.5).margin(0.08));
        CHECK(peaks[0].support_m2 > 0.5F);  // of 1.2
        CHECK((peaks.size() == 1 || peaks[1].support_m2 < 0.7F * peaks[0].support_m2));
    }
}

TEST_CASE("floor and ceiling at one height are two peaks, and weaker ones come later") {
    const auto votes = std::make_unique<PlaneVotes>();
    votes->begin({0.0, 0.0, 1.0});
    for (int i = 0; i < 40; ++i) {
        votes->vote_level(true, 0.5 + 0.002 * (i % 5), 0.05F, 0.01F);
        votes->vote_level(false, 0.5, 0.02F, 0.01F);
        votes->vote_level(true, 1.5, 0.03F, 0.01F);
    }
    const auto peaks = votes->find_peaks(0.3F);
    REQUIRE(peaks.size() == 3);
    CHECK(peaks[0].normal_W.z() == 1.0);
    CHECK(peaks[0].distance_m == Approx(0.504).margin(0.015));
    CHECK(peaks[1].distance_m == Approx(1.5).margin(0.015));
    CHECK(peaks[2].normal_W.z() == -1.0);
    CHECK(peaks[2].distance_m == Approx(-0.5).margin(0.015));
    votes->begin(Vector3d::Zero());
    CHECK(votes->find_peaks(0.01F).empty());
}

TEST_CASE("the histograms follow the vehicle; what is beyond their reach is dropped") {
    const auto votes = std::make_unique<PlaneVotes>();
    const Vector3d far(12345.0, -6789.0, 321.0);
    votes->begin(far);
    for (int i = 0; i < 40; ++i) {
        votes->vote_upright({0.0F, 1.0F, 0.0F}, 0.02F, far + Vector3d(0.1 * i, -2.0, 0.0), 0.05F, 0.02F);
        votes->vote_level(true, far.z() - 8.0, 0.05F, 0.02F);
        votes->vote_upright({1.0F, 0.0F, 0.0F}, 0.02F, far - Vector3d(8.0, 0.0, 0.0), 0.05F, 0.02F);
    }
    const auto peaks = votes->find_peaks(0.3F);
    REQUIRE(peaks.size() == 1);
    CHECK(peaks[0].normal_W.y() > 0.99);
    CHECK(peaks[0].normal_W.dot(far + Vector3d(2.0, -2.0, 0.0)) - peaks[0].distance_m == Approx(0.0).margin(0.12));
}

TEST_CASE("more peaks than there is room for: the strongest stay, and nothing is allocated") {
    const auto votes = std::make_unique<PlaneVotes>();
    const test::AllocationGuard guard;
    votes->begin(Vector3d::Zero());
    for (int i = 0; i < 48; ++i) {
        for (int k = 0; k < 10; ++k) {
            votes->vote_level(true, -7.4 + 0.3 * i, 0.1F + 0.001F * static_cast<float>(i), 0.01F);
        }
    }
    const auto peaks = votes->find_peaks(0.3F);
    const std::uint64_t allocations = guard.allocations();
    CHECK(allocations == 0);
    REQUIRE(peaks.size() == PlaneVotes::kMaxPeaks);
    for (std::size_t i = 0; i < peaks.size(); ++i) {
        CHECK(peaks[i].distance_m > -7.4 + 0.3 * 15);
    }
}

TEST_CASE("votes for azimuths are the same at every bin of the full turn") {
    const auto votes = std::make_unique<PlaneVotes>();
    constexpr double kBin = 2.0 * std::numbers::pi / PlaneVotes::kAzimuthBins;
    for (const double sigma : {0.01, 0.05, 0.12, 0.3}) {  // 1 to 14 bins
        float first = 0.0F;
        for (int bin = 0; bin < PlaneVotes::kAzimuthBins; ++bin) {
            votes->begin(Vector3d::Zero());
            vote_wall(*votes, (bin + 0.25) * kBin, -2.5, 3.0, sigma, 5);
            const auto peaks = votes->find_peaks(0.3F);
            REQUIRE(!peaks.empty());
            first = bin == 0 ? peaks[0].support_m2 : first;
            INFO("bin " << bin << ", sigma " << sigma);
            CHECK(peaks[0].support_m2 == Approx(first).epsilon(1e-4));
            CHECK(peaks[0].distance_m == Approx(-2.5).margin(0.08));
        }
    }
}

}  // namespace
}  // namespace facet::plane_votes_test
