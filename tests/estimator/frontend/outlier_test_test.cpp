// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/outlier_test.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <random>

#include "estimator/geometry/so3.h"

namespace facet::outlier_test_test {
namespace {

constexpr double kFocal = 458.0;
constexpr double kBaseline = 0.11;

struct World {
    std::vector<MonoPair> mono;
    std::vector<StereoPair> stereo;
    std::vector<std::uint8_t> planted;  ///< 1: outlier
};

const Eigen::Matrix3d kNoTurn = Eigen::Matrix3d::Identity();

StereoRig pinhole_rig() {
    const CameraModel camera({752, 480, kFocal, kFocal, 375.5, 239.5, Distortion::kNone, {}});
    StereoRig rig{camera, camera, {}, {}};
    rig.T_B_C1.p.x() = kBaseline;
    return rig;
}

/// Points 1..8 m away seen before and after the motion p_now = R p_before + t, R being known up to `rotation_error`.
World make_world(int points, double outlier_share, const Eigen::Vector3d& t, const Eigen::Vector3d& rotation_error,
                 double noise_px, unsigned seed) {
    std::mt19937 random(seed);
    const auto uniform = [&random](double a, double b) {
        return a + (b - a) * static_cast<double>(random()) / 4294967296.0;
    };
    const auto noise = [&] { return noise_px / kFocal * (uniform(-1, 1) + uniform(-1, 1) + uniform(-1, 1)); };
    const Eigen::Quaterniond q = so3_exp({0.05, -0.1, 0.03});
    World world;
    for (int i = 0; i < points; ++i) {
        const double z = uniform(1.0, 8.0);
        const Eigen::Vector3d before(z * uniform(-0.7, 0.7), z * uniform(-0.5, 0.5), z);
        const Eigen::Vector3d now = q * before + t;
        const Eigen::Vector2d xy_before = before.hnormalized() + Eigen::Vector2d(noise(), noise());
        Eigen::Vector2d xy_now = now.hnormalized() + Eigen::Vector2d(noise(), noise());
        const double rho_before = 1.0 / z + noise() / kBaseline;
        double rho_now = 1.0 / now.z() + noise() / kBaseline;
        const bool bad = i < outlier_share * points;
        if (bad) {
            const double angle = uniform(0.0, 2.0 * M_PI);
            const double size = uniform(15.0, 60.0) / kFocal;
            xy_now += size * Eigen::Vector2d(std::cos(angle), std::sin(angle));
            const double step = uniform(0.0, 1.0) < 0.5 ? -0.5 : 1.0;
            rho_now += (rho_now > 0.25 ? step : 1.0) * (rho_now + 0.2);  // no match is behind the camera
        }
        const Eigen::Quaterniond known = so3_exp(rotation_error) * q;
        world.mono.push_back({known * xy_before.homogeneous(), xy_now});
        world.stereo.push_back({known * (xy_before.homogeneous() / rho_before), xy_now.homogeneous() / rho_now});
        world.planted.push_back(bad ? 1 : 0);
    }
    return world;
}

OutlierTest make_test(std::uint32_t seed = 1, const StereoRig& rig = pinhole_rig()) {
    FrontendConfig config;
    config.seed = seed;
    OutlierTest test;
    test.configure(config, rig);
    return test;
}

int count(const std::vector<std::uint8_t>& flags, const std::vector<std::uint8_t>& planted, bool outliers) {
    int n = 0;
    for (std::size_t i = 0; i < flags.size(); ++i) {
        n += (planted[i] != 0) == outliers && (flags[i] == 0) == outliers ? 1 : 0;
    }
    return n;
}

}  // namespace

TEST_CASE("mono test removes planted outliers and keeps the rest", "[frontend]") {
    const double share = GENERATE(0.0, 0.1, 0.3);
    const Eigen::Vector3d t = GENERATE(Eigen::Vector3d(0.2, 0.02, 0.0), Eigen::Vector3d(0.02, -0.03, -0.3));
    const World world = make_world(200, share, t, Eigen::Vector3d::Zero(), 0.15, 11);
    std::vector<std::uint8_t> inlier(world.mono.size());
    REQUIRE(ok(make_test().mono(world.mono, inlier)));
    const int bad = static_cast<int>(share * 200.0);
    CAPTURE(share, t.transpose());
    // An outlier that moved along its epipolar line cannot be told: 3 px wide line, jumps of 15 to 60 px.
    CHECK(count(inlier, world.planted, true) >= 0.85 * bad);
    CHECK(count(inlier, world.planted, false) >= 200 - bad - 2);
}

TEST_CASE("mono test copes with an error of the gyroscope's rotation", "[frontend]") {
    const World world = make_world(200, 0.1, {0.2, 0.02, 0.05}, {0.004, -0.003, 0.002}, 0.15, 12);
    std::vector<std::uint8_t> inlier(world.mono.size());
    REQUIRE(ok(make_test().mono(world.mono, inlier)));
    CHECK(count(inlier, world.planted, true) >= 16);
    CHECK(count(inlier, world.planted, false) >= 174);
}

TEST_CASE("mono test rejects nothing when it cannot tell", "[frontend]") {
    std::vector<std::uint8_t> inlier(100);
    const auto all_kept = [&inlier] {
        return std::all_of(inlier.begin(), inlier.end(), [](auto f) { return f == 1; });
    };
    // Pure rotation.
    World world = make_world(100, 0.1, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), 0.1, 13);
    CHECK(make_test().mono(world.mono, inlier) == Status::kDegenerate);
    CHECK(all_kept());
    // No motion and no noise at all.
    for (MonoPair& pair : world.mono) {
        pair.rotated = pair.xy.homogeneous();
    }
    CHECK(make_test().mono(world.mono, inlier) == Status::kDegenerate);
    CHECK(all_kept());
    // Mostly outliers.
    world = make_world(100, 0.95, {0.2, 0.0, 0.0}, Eigen::Vector3d::Zero(), 0.1, 14);
    CHECK(make_test().mono(world.mono, inlier) == Status::kDegenerate);
    CHECK(all_kept());
    // Too few.
    inlier.resize(5);
    CHECK(make_test().mono({world.mono.data(), 5}, inlier) == Status::kDegenerate);
    CHECK(all_kept());
    inlier.clear();
    CHECK(make_test().mono({}, inlier) == Status::kDegenerate);
}

TEST_CASE("on a fisheye the mono test measures in the image, up to the border", "[frontend]") {
    const CameraModel camera(
        {752, 480, 270.0, 270.0, 375.5, 239.5, Distortion::kEquidistant, {0.003, 0.001, -0.002, 0.0}});
    const StereoRig rig{camera, camera, {}, {Eigen::Quaterniond::Identity(), Eigen::Vector3d(kBaseline, 0.0, 0.0)}};
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0.0, 0.3);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    World world;
    while (world.mono.size() < 240) {
        const double angle = 1.37 * std::sqrt(uniform(random));  // up to 78 degrees
        const double azimuth = 2.0 * M_PI * uniform(random);
        const Eigen::Vector3d ray(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
                                  std::cos(angle));
        const Eigen::Vector3d before = (1.5 + 4.0 * uniform(random)) * ray;
        Eigen::Vector2d uv_before;
        Eigen::Vector2d uv_now;
        Eigen::Vector2d xy_before;
        Eigen::Vector2d xy_now;
        const bool bad = world.mono.size() < 48;
        if (!ok(camera.project(before, uv_before)) ||
            !ok(camera.project(before + Eigen::Vector3d(0.12, 0.05, -0.1), uv_now))) {
            continue;
        }
        uv_before += Eigen::Vector2d(noise(random), noise(random));
        uv_now += Eigen::Vector2d(noise(random), noise(random));
        uv_now += bad ? Eigen::Vector2d(20.0 * std::cos(5.0 * azimuth), 20.0 * std::sin(5.0 * azimuth))
                      : Eigen::Vector2d(Eigen::Vector2d::Zero());
        if (!ok(camera.unproject(uv_before, xy_before)) || !ok(camera.unproject(uv_now, xy_now))) {
            continue;
        }
        world.mono.push_back({xy_before.homogeneous(), xy_now});
        world.planted.push_back(bad ? 1 : 0);
    }
    std::vector<std::uint8_t> inlier(world.mono.size());
    REQUIRE(ok(make_test(1, rig).mono(world.mono, inlier)));
    CHECK(count(inlier, world.planted, true) >= 40);
    CHECK(count(inlier, world.planted, false) >= 190);
}

TEST_CASE("stereo test removes wrong depths and keeps the rest", "[frontend]") {
    const double share = GENERATE(0.0, 0.2);
    const World world = make_world(200, share, {0.1, 0.02, 0.15}, Eigen::Vector3d::Zero(), 0.2, 15);
    std::vector<std::uint8_t> inlier(world.stereo.size());
    REQUIRE(ok(make_test().stereo(world.stereo, kNoTurn, inlier)));
    const int bad = static_cast<int>(share * 200.0);
    CHECK(count(inlier, world.planted, true) >= 0.9 * bad);
    CHECK(count(inlier, world.planted, false) >= 200 - bad - 4);
}

TEST_CASE("stereo test rejects nothing when it cannot tell", "[frontend]") {
    const World world = make_world(100, 0.97, {0.1, 0.0, 0.1}, Eigen::Vector3d::Zero(), 0.1, 16);
    std::vector<std::uint8_t> inlier(3);
    CHECK(make_test().stereo({world.stereo.data(), 3}, kNoTurn, inlier) == Status::kDegenerate);
    CHECK(std::all_of(inlier.begin(), inlier.end(), [](auto f) { return f == 1; }));
}

TEST_CASE("outlier tests are deterministic", "[frontend]") {
    const World world = make_world(300, 0.3, {0.2, 0.02, 0.0}, Eigen::Vector3d::Zero(), 0.5, 17);
    std::vector<std::uint8_t> first(300);
    std::vector<std::uint8_t> second(300);
    OutlierTest test = make_test();
    REQUIRE(ok(test.mono(world.mono, first)));
    REQUIRE(ok(test.mono(world.mono, second)));
    CHECK(first == second);
    REQUIRE(ok(test.stereo(world.stereo, kNoTurn, first)));
    OutlierTest other = make_test();
    REQUIRE(ok(other.stereo(world.stereo, kNoTurn, second)));
    CHECK(first == second);
}

}  // namespace facet::outlier_test_test
