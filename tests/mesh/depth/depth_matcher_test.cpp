// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/depth/depth_matcher.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "estimator/frontend/image_pyramid.h"
#include "tests/mesh/depth/stereo_scene.h"

namespace facet::depth_matcher_test {
namespace {

using test::ScenePair;

/// A matcher on one stereo pair.
struct Bench {
    DepthMatcher matcher;
    ImagePyramid left;
    ImagePyramid right;

    explicit Bench(const ScenePair& pair, const StereoRig& rig = test::scene_rig()) {
        matcher.configure(rig);
        REQUIRE(ok(left.configure(test::kSceneWidth, test::kSceneHeight, 1)));
        REQUIRE(ok(right.configure(test::kSceneWidth, test::kSceneHeight, 1)));
        left.build(pair.left.view());
        right.build(pair.right.view());
    }

    DepthVerdict match(const Eigen::Vector2d& uv, const DepthRange& range, DepthMatch& found) {
        DepthMatcher::Ray ray;
        Eigen::Vector2d xy;
        REQUIRE(ok(matcher.ray_of(uv, ray, xy)));
        const ImageView& image = left.level(0);
        const int u = static_cast<int>(uv.x());
        const int v = static_cast<int>(uv.y());
        const Eigen::Vector2f gradient(0.5F * static_cast<float>(image.at(u + 1, v) - image.at(u - 1, v)),
                                       0.5F * static_cast<float>(image.at(u, v + 1) - image.at(u, v - 1)));
        return matcher.match(left.pairs(0), right.pairs(0), ray, gradient, range, found);
    }
};

constexpr DepthRange kAll{0.0, 1.0 / 0.6};

struct Tally {
    int tried = 0;
    int matched = 0;
    int within_three_sigmas = 0;
    int wrong = 0;  ///< by more than a pixel
    double squares = 0.0;

    void add(DepthVerdict verdict, const DepthMatch& match, double true_inverse_depth) {
        ++tried;
        if (verdict == DepthVerdict::kMatched) {
            const double error = match.inverse_depth - true_inverse_depth;
            ++matched;
            within_three_sigmas += std::abs(error) < 3.0 * match.sigma ? 1 : 0;
            wrong += std::abs(error) > match.per_px ? 1 : 0;
            squares += error * error / (match.sigma * match.sigma);
        }
    }
};

Tally match_plane(const Eigen::Vector3d& normal, double distance, Bench& bench) {
    Tally tally;
    for (int v = 20; v < 220; v += 10) {
        for (int u = 80; u < 300; u += 10) {
            DepthMatch match;
            const DepthVerdict verdict = bench.match({u, v}, kAll, match);
            Eigen::Vector2d xy;
            REQUIRE(ok(test::scene_rig().left.unproject({u, v}, xy)));
            tally.add(verdict, match, normal.dot(xy.homogeneous()) / distance);
        }
    }
    return tally;
}

TEST_CASE("the depth of a plane is found to its uncertainty, facing or slanted") {
    for (const double turn : {0.0, 0.6}) {
        const Eigen::Vector3d normal(std::sin(turn), 0.3 * std::sin(turn), std::cos(turn));
        Bench bench(ScenePair(test::plane_surface(normal, 2.0)));
        const Tally tally = match_plane(normal, 2.0, bench);
        CAPTURE(turn, tally.tried, tally.matched, tally.within_three_sigmas, tally.wrong);
        CHECK(tally.matched > tally.tried / 2);
        CHECK(tally.wrong == 0);
        CHECK(tally.within_three_sigmas >= 0.98 * tally.matched);
        // Not merely by claiming little.
        CHECK(tally.squares / tally.matched > 0.1);
        CHECK(tally.squares / tally.matched < 2.0);
    }
}

TEST_CASE("a corrected calibration is what counts") {
    const Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    StereoRig wrong = test::scene_rig();
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()));
    wrong.T_B_C1.q = turned;  // 2.4 px of disparity
    Bench bench(ScenePair(test::plane_surface(normal, 2.0)), wrong);
    CHECK(match_plane(normal, 2.0, bench).wrong > 100);
    CameraCorrections corrections;
    corrections.right.q = turned.inverse();
    bench.matcher.correct(corrections);
    CHECK(match_plane(normal, 2.0, bench).wrong == 0);
}

TEST_CASE("what has no texture is not matched") {
    test::Surface bare = test::plane_surface(Eigen::Vector3d::UnitZ(), 2.0);
    bare.grey = [](const Eigen::Vector3d& p) { return 120.0 + 2.0 * p.x(); };
    Bench bench{ScenePair(bare)};
    CHECK(match_plane(Eigen::Vector3d::UnitZ(), 2.0, bench).matched == 0);
}

TEST_CASE("a repeated texture is refused where all depths are possible, and matched where one is") {
    test::Surface stripes = test::plane_surface(Eigen::Vector3d::UnitZ(), 2.0);
    stripes.grey = [](const Eigen::Vector3d& p) {
        return 128.0 + 60.0 * std::sin(2.0 * std::numbers::pi * p.x() / 0.08) +
               40.0 * std::sin(2.0 * std::numbers::pi * p.y() / 0.11);
    };
    Bench bench{ScenePair(stripes)};
    const Tally tally = match_plane(Eigen::Vector3d::UnitZ(), 2.0, bench);
    CHECK(tally.matched == 0);
    DepthMatch match;
    CHECK(bench.match({160.0, 120.0}, kAll, match) == DepthVerdict::kAmbiguous);
    REQUIRE(bench.match({160.0, 120.0}, {0.4, 0.6}, match) == DepthVerdict::kMatched);
    CHECK(match.inverse_depth == Approx(0.5).margin(3.0 * match.sigma));
}

TEST_CASE("at a step each side has its own depth, and what the right camera cannot see has none") {
    Bench bench{ScenePair(test::step_surface(1.5, 3.0))};
    int near = 0;
    int far = 0;
    int hidden = 0;
    int hidden_tried = 0;
    int wrong = 0;
    for (int v = 20; v < 220; v += 5) {
        for (int u = 100; u < 240; u += 3) {
            DepthMatch match;
            hidden_tried += u >= 152 && u < 160 ? 1 : 0;
            if (bench.match({u, v}, kAll, match) != DepthVerdict::kMatched) {
                continue;
            }
            // Hidden from the right camera: 16 - 8 px beside the edge at u = 159.5.
            const bool is_hidden = u >= 152 && u < 160;
            const bool is_near = std::abs(match.inverse_depth - 1.0 / 1.5) < match.per_px;
            const bool is_far = std::abs(match.inverse_depth - 1.0 / 3.0) < match.per_px;
            near += u > 163 && is_near ? 1 : 0;
            far += u < 148 && is_far ? 1 : 0;
            hidden += is_hidden && !is_near ? 1 : 0;
            // The window reaches four pixels over the edge.
            wrong += (u > 163 && !is_near) || (u < 148 && !is_far) ? 1 : 0;
        }
    }
    CAPTURE(near, far, hidden, hidden_tried, wrong);
    CHECK(near > 200);
    CHECK(far > 200);
    CHECK(wrong <= 2);
    CHECK(5 * hidden < hidden_tried);
}

TEST_CASE("the best place must lie within the depths searched") {
    Bench bench{ScenePair(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.0))};
    int matched = 0;
    for (int u = 80; u < 300; u += 10) {
        DepthMatch match;
        matched += bench.match({u, 100}, {0.8, 1.2}, match) == DepthVerdict::kMatched ? 1 : 0;
    }
    CHECK(matched <= 1);
}

}  // namespace
}  // namespace facet::depth_matcher_test
