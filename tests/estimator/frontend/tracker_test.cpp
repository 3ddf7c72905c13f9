// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/tracker.h"

#include <catch2/catch.hpp>

#include "estimator/values/capacity.h"
#include "tests/estimator/frontend/synthetic.h"

namespace facet::tracker_test {

using synthetic::Texture;

namespace {

struct Scene {
    StereoRig rig = synthetic::make_rig();
    FrontendConfig config;
    Tracker tracker;
    ImagePyramid images[2];

    Scene() {
        REQUIRE(ok(tracker.configure(config, rig.left)));
        for (ImagePyramid& image : images) {
            REQUIRE(ok(image.configure(320, 240, config.pyramid_levels)));
        }
    }
};

}  // namespace

TEST_CASE("tracks follow a turning and moving camera without drift", "[frontend]") {
    Scene scene;
    const synthetic::Plane plane{Eigen::Vector3d(0.1, 0.05, 1.0).normalized(), 2.0};
    const Texture texture(0.09, 0.5, 21);
    const auto pose_at = [](int k) {
        const double s = 0.05 * k;
        return Se3{so3_exp({0.2 * s, -0.3 * s, 0.8 * s}), {0.3 * s, -0.1 * s, 0.4 * s}};
    };
    scene.images[0].build(synthetic::render(plane, texture, scene.rig.left, pose_at(0)).view());
    std::vector<Track> tracks;
    std::vector<Eigen::Vector3d> points;
    for (int v = 50; v < 200; v += 30) {
        for (int u = 50; u < 280; u += 30) {
            Track track;
            REQUIRE(ok(scene.tracker.start(scene.images[0], Eigen::Vector2d(u, v), track)));
            tracks.push_back(track);
            points.push_back(plane.intersect(pose_at(0).p, pose_at(0).q * track.xy.homogeneous()));
        }
    }
    constexpr int kFrames = 12;
    int lost = 0;
    std::vector<bool> alive(tracks.size(), true);
    for (int k = 1; k <= kFrames; ++k) {
        ImagePyramid& previous = scene.images[(k + 1) % 2];
        ImagePyramid& present = scene.images[k % 2];
        present.build(synthetic::render(plane, texture, scene.rig.left, pose_at(k)).view());
        const FrameMotion motion{pose_at(k).q.conjugate() * pose_at(k - 1).q, 0.05};
        double worst = 0.0;
        double mean = 0.0;
        int n = 0;
        for (std::size_t i = 0; i < tracks.size(); ++i) {
            Eigen::Vector2d truth;
            REQUIRE(ok(scene.rig.left.project(pose_at(k).inverse() * points[i], truth)));
            if (!alive[i]) {
                continue;
            }
            if (!ok(scene.tracker.follow(previous, present, motion, tracks[i]))) {
                alive[i] = false;
                lost += scene.rig.left.in_image(truth, 20.0) ? 1 : 0;
                continue;
            }
            const double error = (tracks[i].pose.uv - truth).norm();
            worst = std::max(worst, error);
            mean += error;
            ++n;
            Eigen::Vector2d xy;
            REQUIRE(ok(scene.rig.left.unproject(tracks[i].pose.uv, xy)));
            CHECK((xy - tracks[i].xy).norm() < 1e-12);
            CHECK(tracks[i].age_frames == static_cast<std::uint32_t>(k));
        }
        CAPTURE(k, n, worst, mean / n);
        CHECK(mean / n < 0.03);
        CHECK(worst < 0.12);
    }
    CHECK(lost == 0);
}

TEST_CASE("tracks survive a change of exposure", "[frontend]") {
    Scene scene;
    const Texture texture(11.0, 50.0, 22);
    scene.images[0].build(synthetic::warp(texture, 320, 240, {0.0, 0.0}).view());
    scene.images[1].build(
        synthetic::warp(texture, 320, 240, {2.3, -1.6}, Eigen::Matrix2d::Identity(), 1.3, -15.0).view());
    for (int u = 60; u < 270; u += 30) {
        Track track;
        REQUIRE(ok(scene.tracker.start(scene.images[0], Eigen::Vector2d(u, 120), track)));
        REQUIRE(
            ok(scene.tracker.follow(scene.images[0], scene.images[1], {Eigen::Quaterniond::Identity(), 0.05}, track)));
        CHECK((track.pose.uv - Eigen::Vector2d(u + 2.3, 118.4)).norm() < 0.1);
    }
}

TEST_CASE("tracks end in images that show something else", "[frontend]") {
    Scene scene;
    scene.images[0].build(synthetic::warp(Texture(11.0, 50.0, 23), 320, 240, {0.0, 0.0}).view());
    const FrameMotion still{Eigen::Quaterniond::Identity(), 0.05};
    Track track;
    REQUIRE(ok(scene.tracker.start(scene.images[0], {150.0, 120.0}, track)));
    const Track before = track;
    scene.images[1].build(synthetic::Image(320, 240, 0).view());
    CHECK(!ok(scene.tracker.follow(scene.images[0], scene.images[1], still, track)));
    CHECK(track.pose.uv == before.pose.uv);
    CHECK(track.age_frames == 0);
    int followed = 0;
    scene.images[1].build(synthetic::warp(Texture(11.0, 50.0, 99), 320, 240, {0.0, 0.0}).view());
    for (int u = 40; u < 280; u += 10) {
        REQUIRE(ok(scene.tracker.start(scene.images[0], Eigen::Vector2d(u, 120), track)));
        followed += ok(scene.tracker.follow(scene.images[0], scene.images[1], still, track)) ? 1 : 0;
    }
    CHECK(followed <= 1);
}

TEST_CASE("tracker has a fixed number of templates and takes freed ones again", "[frontend]") {
    Scene scene;
    scene.images[0].build(synthetic::warp(Texture(11.0, 50.0, 24), 320, 240, {0.0, 0.0}).view());
    Track track;
    for (int i = 0; i < kMaxFeatures + kMaxDormantTracks; ++i) {
        REQUIRE(ok(scene.tracker.start(scene.images[0], {150.0, 120.0}, track)));
    }
    Track refused;
    CHECK(scene.tracker.start(scene.images[0], {150.0, 120.0}, refused) == Status::kFull);
    scene.tracker.stop(track);
    CHECK(ok(scene.tracker.start(scene.images[0], {150.0, 120.0}, refused)));
    CHECK(refused.slot == track.slot);
    scene.tracker.reset();
    CHECK(ok(scene.tracker.start(scene.images[0], {150.0, 120.0}, refused)));
}

}  // namespace facet::tracker_test
