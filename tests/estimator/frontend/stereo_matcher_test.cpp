// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/stereo_matcher.h"

#include <catch2/catch.hpp>

#include "estimator/frontend/detector.h"
#include "tests/estimator/frontend/synthetic.h"

namespace facet::stereo_matcher_test {

using synthetic::Texture;

namespace {

struct Pair {
    StereoRig rig;
    FrontendConfig config;
    StereoMatcher matcher;
    ImagePyramid left;
    ImagePyramid right;

    explicit Pair(const StereoRig& cameras = synthetic::make_rig()) : rig(cameras) {
        REQUIRE(ok(matcher.configure(config, rig)));
        REQUIRE(ok(left.configure(320, 240, config.pyramid_levels)));
        REQUIRE(ok(right.configure(320, 240, config.pyramid_levels)));
    }
    /// World = left camera.
    template <class T>
    void see(const synthetic::Plane& plane, const T& texture) {
        left.build(synthetic::render(plane, texture, rig.left, Se3{}).view());
        right.build(synthetic::render(plane, texture, rig.right, rig.T_C1_C0().inverse()).view());
    }
};

}  // namespace

TEST_CASE("stereo matches a slanted plane through two distorted cameras", "[frontend]") {
    const double distance = GENERATE(0.5, 1.5, 4.0);
    Pair pair;
    const synthetic::Plane plane{Eigen::Vector3d(0.25, -0.1, 1.0).normalized(), distance};
    pair.see(plane, Texture(0.045 * distance, 0.5 * distance, 31));
    int seen = 0;
    int matched = 0;
    double worst_px = 0.0;
    double mean_px = 0.0;
    Detector detector;
    FrontendConfig detection;
    detection.corners.min_distance_px = 10.0;
    detector.configure(detection, pair.rig.left, 12.0);
    CornerList corners;
    detector.detect(pair.left.level(0), {}, 250, corners);
    for (const Eigen::Vector2d& corner : corners) {
        Eigen::Vector2d xy;
        REQUIRE(ok(pair.rig.left.unproject(corner, xy)));
        const Eigen::Vector3d p_C0 = plane.intersect(Eigen::Vector3d::Zero(), xy.homogeneous());
        Eigen::Vector2d truth;
        if (!ok(pair.rig.right.project(pair.rig.T_C1_C0() * p_C0, truth)) || !pair.rig.right.in_image(truth, 12.0)) {
            continue;
        }
        ++seen;
        StereoMatch match;
        if (!ok(pair.matcher.match(pair.left, pair.right, corner, -1.0, match))) {
            continue;
        }
        ++matched;
        worst_px = std::max(worst_px, (match.right_uv - truth).norm());
        mean_px += (match.right_uv - truth).norm();
        // Depth error of 0.2 px of disparity.
        CHECK(std::abs(match.inverse_depth - 1.0 / p_C0.z()) < 0.2 / (200.0 * 0.11));
        CHECK((match.p_C0.hnormalized() - xy).norm() < 1e-9);
        // Known depth gives the same match.
        StereoMatch again;
        REQUIRE(ok(pair.matcher.match(pair.left, pair.right, corner, 1.1 * match.inverse_depth, again)));
        CHECK((again.right_uv - match.right_uv).norm() < 0.05);
    }
    CAPTURE(distance, seen, matched, mean_px / matched, worst_px);
    CHECK(seen > 100);
    CHECK(matched > 0.8 * seen);
    CHECK(mean_px / matched < 0.05);
    CHECK(worst_px < 0.3);
}

TEST_CASE("stereo matches a floor and what lies beside it through two fisheyes", "[frontend]") {
    const auto camera = [](double cx, double cy) {
        return CameraModel({320, 240, 115.0, 115.2, cx, cy, Distortion::kEquidistant, {0.003, 0.001, -0.002, 0.0003}});
    };
    StereoRig rig = synthetic::make_rig();
    rig.left = camera(160.7, 121.0);
    rig.right = camera(158.2, 118.4);
    Pair pair(rig);
    // The plane is seen at 2 m in front, and up to 6 m away at 70 degrees.
    const synthetic::Plane plane{Eigen::Vector3d(0.0, 0.6, 0.8), 1.6};
    pair.see(plane, Texture(0.12, 1.6, 33));
    Detector detector;
    FrontendConfig detection;
    detection.corners.min_distance_px = 10.0;
    detector.configure(detection, rig.left, 12.0);
    CornerList corners;
    detector.detect(pair.left.level(0), {}, 250, corners);
    int seen = 0;
    int matched = 0;
    int wide = 0;
    double mean_px = 0.0;
    double worst_px = 0.0;
    for (const Eigen::Vector2d& corner : corners) {
        Eigen::Vector2d xy;
        REQUIRE(ok(rig.left.unproject(corner, xy)));  // no corner outside the lens
        const Eigen::Vector3d p_C0 = plane.intersect(Eigen::Vector3d::Zero(), xy.homogeneous());
        Eigen::Vector2d truth;
        if (!(p_C0.z() > 0.4 && p_C0.norm() < 6.0) || !ok(rig.right.project(rig.T_C1_C0() * p_C0, truth)) ||
            !rig.right.in_image(truth, 12.0)) {
            continue;
        }
        ++seen;
        StereoMatch match;
        if (ok(pair.matcher.match(pair.left, pair.right, corner, -1.0, match))) {
            ++matched;
            wide += xy.norm() > 1.7 ? 1 : 0;  // beyond 60 degrees
            mean_px += (match.right_uv - truth).norm();
            worst_px = std::max(worst_px, (match.right_uv - truth).norm());
        }
    }
    CAPTURE(seen, matched, wide, mean_px / matched, worst_px);
    CHECK(seen > 60);
    CHECK(matched > 0.7 * seen);
    CHECK(wide > 20);
    CHECK(mean_px / matched < 0.1);
    CHECK(worst_px < 1.0);
}

TEST_CASE("stereo ignores a wrong known depth", "[frontend]") {
    Pair pair;
    const synthetic::Plane plane{Eigen::Vector3d::UnitZ(), 2.0};
    pair.see(plane, Texture(0.09, 1.0, 32));
    int wrong = 0;
    int matched = 0;
    for (int u = 60; u < 280; u += 10) {
        StereoMatch match;
        if (ok(pair.matcher.match(pair.left, pair.right, Eigen::Vector2d(u, 120), 1.0 / 0.6, match))) {
            ++matched;
            wrong += std::abs(match.inverse_depth - 0.5) > 0.02 ? 1 : 0;
        }
    }
    CHECK(wrong == 0);
    CHECK(matched >= 15);
}

TEST_CASE("stereo leaves repeated patterns alone", "[frontend]") {
    // Period 0.1 m at 2 m: 10 px, several periods within the searched range.
    struct Checks {
        double at(double x, double y) const {
            return 128.0 + 50.0 * std::sin(2.0 * M_PI * x / 0.1) * std::sin(2.0 * M_PI * y / 0.1);
        }
    };
    Pair pair;
    const synthetic::Plane plane{Eigen::Vector3d::UnitZ(), 2.0};
    synthetic::Image left(320, 240);
    synthetic::Image right(320, 240);
    const auto paint = [&](synthetic::Image& image, const CameraModel& camera, const Se3& T_W_C) {
        for (int v = 0; v < 240; ++v) {
            for (int u = 0; u < 320; ++u) {
                Eigen::Vector2d xy;
                REQUIRE(ok(camera.unproject(Eigen::Vector2d(u, v), xy)));
                const Eigen::Vector3d p = plane.intersect(T_W_C.p, T_W_C.q * xy.homogeneous());
                image.set(u, v, Checks{}.at(p.x(), p.y()));
            }
        }
    };
    paint(left, pair.rig.left, Se3{});
    paint(right, pair.rig.right, pair.rig.T_C1_C0().inverse());
    pair.left.build(left.view());
    pair.right.build(right.view());
    int wrong = 0;
    int asked = 0;
    for (int v = 60; v < 180; v += 12) {
        for (int u = 100; u < 260; u += 9) {
            StereoMatch match;
            ++asked;
            if (ok(pair.matcher.match(pair.left, pair.right, Eigen::Vector2d(u, v), -1.0, match))) {
                wrong += std::abs(match.inverse_depth - 0.5) > 0.02 ? 1 : 0;
            }
        }
    }
    CAPTURE(asked);
    CHECK(wrong <= asked / 50);
}

TEST_CASE("stereo finds nothing in a blank or different right image", "[frontend]") {
    Pair pair;
    const synthetic::Plane plane{Eigen::Vector3d::UnitZ(), 2.0};
    pair.see(plane, Texture(0.09, 1.0, 33));
    pair.right.build(synthetic::Image(320, 240, 0).view());
    StereoMatch match;
    match.inverse_depth = 7.0;
    CHECK(!ok(pair.matcher.match(pair.left, pair.right, {160.0, 120.0}, -1.0, match)));
    CHECK(!ok(pair.matcher.match(pair.left, pair.right, {2.0, 2.0}, -1.0, match)));
    CHECK(match.inverse_depth == 7.0);
    pair.right.build(synthetic::warp(Texture(11.0, 50.0, 34), 320, 240, {0.0, 0.0}).view());
    int matched = 0;
    int asked = 0;
    for (int v = 60; v < 180; v += 12) {
        for (int u = 100; u < 260; u += 9) {
            ++asked;
            matched += ok(pair.matcher.match(pair.left, pair.right, Eigen::Vector2d(u, v), -1.0, match)) ? 1 : 0;
        }
    }
    CAPTURE(asked);
    CHECK(matched <= asked / 50);
}

namespace {

struct Matches {
    int found = 0;
    int wrong = 0;
};

/// Matches a grid of pixels on a plane 2 m away with what is believed of the cameras.
Matches match_grid(Pair& pair, const CameraCorrections* corrections) {
    REQUIRE(ok(pair.matcher.configure(pair.config, pair.rig)));
    if (corrections != nullptr) {
        pair.matcher.correct(*corrections);
    }
    Matches matches;
    for (int v = 40; v < 210; v += 12) {
        for (int u = 60; u < 290; u += 12) {
            StereoMatch match;
            if (ok(pair.matcher.match(pair.left, pair.right, Eigen::Vector2d(u, v), -1.0, match))) {
                ++matches.found;
                matches.wrong += std::abs(match.inverse_depth - 0.5) > 0.02 ? 1 : 0;
                Eigen::Vector2d xy;
                REQUIRE(ok(pair.rig.right.unproject(match.right_uv, xy)));
                CHECK(match.right_xy == xy);
            }
        }
    }
    return matches;
}

}  // namespace

TEST_CASE("stereo follows what is known of the calibration", "[frontend]") {
    Pair pair;
    pair.see({Eigen::Vector3d::UnitZ(), 2.0}, Texture(0.09, 1.0, 35));
    const Matches right = match_grid(pair, nullptr);
    CHECK(right.found > 200);

    // The right image lies 2.5 px lower than the principal point that is given.
    CameraIntrinsics wrong = pair.rig.right.intrinsics();
    wrong.cy -= 2.5;
    pair.rig.right = CameraModel(wrong);
    CHECK(match_grid(pair, nullptr).found < 0.1 * right.found);

    CameraCorrections unsure;
    unsure.covariance(17, 17) = 0.5 * 0.5;
    const Matches wide = match_grid(pair, &unsure);
    CHECK(wide.found > 0.97 * right.found);
    CHECK(wide.wrong <= 2);

    CameraCorrections sure;
    sure.lens[1](3) = 2.5;
    const Matches found = match_grid(pair, &sure);
    CHECK(found.found > 0.97 * right.found);
    CHECK(found.wrong <= 2);

    sure.lens[1](3) = -2.5;
    CHECK(match_grid(pair, &sure).found < 0.1 * right.found);
}

}  // namespace facet::stereo_matcher_test
