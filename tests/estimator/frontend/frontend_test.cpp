// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/frontend.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "estimator/frontend/feature_engine.h"
#include "tests/estimator/frontend/given_landmarks.h"
#include "tests/estimator/frontend/plane_flight.h"
#include "tests/estimator/frontend/same_output.h"

namespace facet::frontend_test {

using synthetic::Image;
using test::flight;
using test::Flight;
using test::small_config;

namespace {

/// Runs the test case once for each backend that this build has.
FrontendConfig each_backend() {
    FrontendConfig config = small_config();
    config.backend = GENERATE(range(0, has_opencv_engine() ? 2 : 1));
    return config;
}

/// Distances of tracks and matches from where their points are (px).
struct TrackErrors {
    std::vector<double> left;
    std::vector<double> right;

    void add_left(double px) { left.push_back(px); }
    void add_right(double px) { right.push_back(px); }
    /// Our own patches follow the slant of the surface and do not drift; OpenCV's do neither, and some are far off.
    void check(const FrontendConfig& config) {
        std::sort(left.begin(), left.end());
        std::sort(right.begin(), right.end());
        REQUIRE(right.size() > 100);
        CHECK(left.back() < (config.uses_opencv() ? 3.0 : 0.35));
        CHECK(right.back() < (config.uses_opencv() ? 2.0 : 0.2));
        CHECK(left[left.size() / 2] < 0.35);
        CHECK(right[right.size() / 2] < 0.2);
    }
};

}  // namespace

TEST_CASE("front-end tracks and matches a flight over a plane to a fraction of a pixel", "[frontend]") {
    const FrontendConfig config = each_backend();
    CAPTURE(config.backend);
    const Flight& f = flight();
    Frontend frontend;
    REQUIRE(ok(frontend.configure(config, f.rig)));
    TrackErrors errors;
    std::map<std::uint32_t, Eigen::Vector3d> points;
    std::uint32_t newest = 0;
    int keyframes = 0;
    for (std::size_t k = 0; k < f.frames.size(); ++k) {
        CAPTURE(k);
        FrontendOutput out;
        REQUIRE(ok(frontend.process(f.frames[k].view(), f.hints(k), out)));
        CHECK(out.stamp == f.frames[k].stamp);
        CHECK(out.observations.size() > 80);
        CHECK(static_cast<int>(out.observations.size()) == out.tracked + out.detected);
        const Se3 T_C0_W = (f.frames[k].T_W_B * f.rig.T_B_C0).inverse();
        const Se3 T_C1_W = (f.frames[k].T_W_B * f.rig.T_B_C1).inverse();
        int stereo = 0;
        for (const FeatureObservation& o : out.observations) {
            if (points.count(o.landmark.value) == 0) {
                CHECK(out.is_keyframe);
                CHECK(o.age_frames == 0);
                CHECK((points.empty() || o.landmark.value > newest));
                newest = o.landmark.value;
                const Se3 T_W_C0 = T_C0_W.inverse();
                points[o.landmark.value] = f.plane.intersect(T_W_C0.p, T_W_C0.q * o.left_xy.homogeneous());
            }
            const Eigen::Vector3d& p_W = points[o.landmark.value];
            errors.add_left(((T_C0_W * p_W).hnormalized() - o.left_xy).norm() * f.rig.left.focal_px());
            Eigen::Vector2d px;
            REQUIRE(ok(f.rig.left.project(o.left_xy.homogeneous(), px)));
            CHECK((px - o.left_px.cast<double>()).norm() < 1e-3);
            stereo += o.has_right ? 1 : 0;
            if (o.has_right) {
                CHECK(out.is_keyframe);
                errors.add_right(((T_C1_W * p_W).hnormalized() - o.right_xy).norm() * f.rig.right.focal_px());
            }
        }
        CHECK(out.stereo == stereo);
        keyframes += out.is_keyframe ? 1 : 0;
        if (out.is_keyframe) {
            CHECK(stereo > 0.7 * static_cast<double>(out.observations.size()));
        }
        if (k >= 4 && k < 6) {
            CHECK(out.is_still);
            CHECK_FALSE(out.is_keyframe);
        }
        if (k >= 8) {
            CHECK_FALSE(out.is_still);
        }
        CHECK(out.outliers == 0);
    }
    CHECK(keyframes >= 3);
    errors.check(config);
}

TEST_CASE("surface points are matched between the tracks at keyframes, and tracks do not notice", "[frontend]") {
    const Flight& f = flight();
    Frontend frontend;
    Frontend without;
    FrontendConfig config = each_backend();
    config.surface_points = 100;
    REQUIRE(ok(frontend.configure(config, f.rig)));
    config.surface_points = 0;
    REQUIRE(ok(without.configure(config, f.rig)));
    std::set<LandmarkId> ids;
    std::size_t told = 0;
    int keyframes = 0;
    for (std::size_t k = 0; k < f.frames.size(); ++k) {
        CAPTURE(k);
        FrontendOutput out;
        FrontendOutput plain;
        FrameHints hints = f.hints(k);
        hints.effort = k < 12 ? 1.0 : 0.67;  // late: no time for them
        REQUIRE(ok(frontend.process(f.frames[k].view(), hints, out)));
        REQUIRE(ok(without.process(f.frames[k].view(), hints, plain)));
        CHECK(out.surface.empty());
        frontend.match_surface(out);
        without.match_surface(plain);
        const std::size_t found = out.surface.size();
        frontend.match_surface(out);
        CHECK(out.surface.size() == found);  // once
        CHECK(plain.surface.empty());
        CHECK((out.surface.empty() || (out.is_keyframe && k < 12)));
        CHECK(out.surface.size() <= 100);
        REQUIRE(out.observations.size() == plain.observations.size());
        for (std::size_t i = 0; i < out.observations.size(); ++i) {
            REQUIRE(out.observations[i].left_xy == plain.observations[i].left_xy);
            // OpenCV's matches notice each other in the sixth digit.
            const double apart = (out.observations[i].right_xy - plain.observations[i].right_xy).norm();
            REQUIRE(apart <= (config.uses_opencv() ? 1e-5 : 0.0));
        }
        const Se3 T_W_C0 = f.frames[k].T_W_B * f.rig.T_B_C0;
        const Se3 T_C1_W = (f.frames[k].T_W_B * f.rig.T_B_C1).inverse();
        for (const FeatureObservation& o : out.surface) {
            const Eigen::Vector3d p_W = f.plane.intersect(T_W_C0.p, T_W_C0.q * o.left_xy.homogeneous());
            CHECK(o.has_right);
            CHECK(((T_C1_W * p_W).hnormalized() - o.right_xy).norm() * f.rig.right.focal_px() <
                  (config.uses_opencv() ? 2.0 : 0.3));
            CHECK(ids.insert(o.landmark).second);
            for (const FeatureObservation& track : out.observations) {
                REQUIRE(track.landmark != o.landmark);
                REQUIRE((track.left_px - o.left_px).norm() > static_cast<float>(config.corners.min_distance_px) - 1.0F);
            }
        }
        told += out.surface.size();
        keyframes += out.surface.empty() ? 0 : 1;
    }
    CHECK(keyframes >= 2);
    CHECK(told > 40U * static_cast<unsigned>(keyframes));
}

TEST_CASE("front-end gives the same output for the same input", "[frontend]") {
    const FrontendConfig config = each_backend();
    CAPTURE(config.backend);
    const Flight& f = flight();
    Frontend first;
    Frontend second;
    REQUIRE(ok(first.configure(config, f.rig)));
    REQUIRE(ok(second.configure(config, f.rig)));
    for (std::size_t k = 0; k < f.frames.size(); ++k) {
        FrontendOutput a;
        FrontendOutput b;
        REQUIRE(ok(first.process(f.frames[k].view(), f.hints(k), a)));
        REQUIRE(ok(second.process(f.frames[k].view(), f.hints(k), b)));
        first.match_surface(a);
        second.match_surface(b);
        CHECK(test::same(a, b));
    }
}

TEST_CASE("front-end refuses bad input and goes on as if it had not come", "[frontend]") {
    const FrontendConfig config = each_backend();
    CAPTURE(config.backend);
    const Flight& f = flight();
    Frontend undisturbed;
    Frontend frontend;
    FrontendOutput out;
    CHECK(frontend.process(f.frames[0].view(), f.hints(0), out) == Status::kInvalidArgument);  // not configured
    REQUIRE(ok(undisturbed.configure(config, f.rig)));
    REQUIRE(ok(frontend.configure(config, f.rig)));
    const Image small(160, 120, 100);
    FrameHints impossible;
    impossible.q_Bp_B = Eigen::Quaterniond(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0, 0.0);
    for (std::size_t k = 0; k < 8; ++k) {
        FrontendOutput expected;
        REQUIRE(ok(undisturbed.process(f.frames[k].view(), f.hints(k), expected)));
        REQUIRE(ok(frontend.process(f.frames[k].view(), f.hints(k), out)));
        CHECK(test::same(out, expected));
        StereoFrame later = f.frames[k].view();
        later.stamp = later.stamp + Duration{1000};
        StereoFrame bad = later;
        bad.left = {};
        CHECK(frontend.process(bad, f.hints(k), out) == Status::kInvalidArgument);
        bad.left = small.view();
        CHECK(frontend.process(bad, f.hints(k), out) == Status::kInvalidArgument);
        bad = later;
        bad.right = small.view();
        CHECK(frontend.process(bad, f.hints(k), out) == Status::kInvalidArgument);
        CHECK(frontend.process(later, impossible, out) == Status::kInvalidArgument);
        CHECK(frontend.process(f.frames[k].view(), f.hints(k), out) == Status::kOutOfOrder);
        CHECK(frontend.process(f.frames[0].view(), f.hints(k), out) == Status::kOutOfOrder);
        CHECK(test::same(out, expected));
    }
}

TEST_CASE("front-end outlives darkness and starts again", "[frontend]") {
    const FrontendConfig config = each_backend();
    CAPTURE(config.backend);
    const Flight& f = flight();
    Frontend frontend;
    REQUIRE(ok(frontend.configure(config, f.rig)));
    FrontendOutput out;
    REQUIRE(ok(frontend.process(f.frames[0].view(), f.hints(0), out)));
    const std::uint32_t newest = out.observations.back().landmark.value;
    const Image black(320, 240, 0);
    for (std::size_t k = 1; k < 8; ++k) {
        REQUIRE(ok(frontend.process({f.frames[k].stamp, black.view(), black.view()}, f.hints(k), out)));
        CHECK(out.observations.empty());
        CHECK(out.stereo == 0);
        CHECK_FALSE(out.is_still);
    }
    std::size_t features = 0;
    for (std::size_t k = 8; k < 13; ++k) {
        REQUIRE(ok(frontend.process(f.frames[k].view(), f.hints(k), out)));
        features = out.observations.size();
    }
    CHECK(features > 80);
    CHECK(out.observations.front().landmark.value > newest);
}

TEST_CASE("front-end finds landmarks again after darkness where they are predicted", "[frontend]") {
    const Flight& f = flight();
    Frontend frontend;
    REQUIRE(ok(frontend.configure(small_config(), f.rig)));
    FrontendOutput out;
    REQUIRE(ok(frontend.process(f.frames[5].view(), f.hints(0), out)));
    std::map<LandmarkId, Eigen::Vector3d> points;
    const Se3 T_W_C = f.frames[5].T_W_B * f.rig.T_B_C0;
    for (const FeatureObservation& o : out.observations) {
        points[o.landmark] = f.plane.intersect(T_W_C.p, T_W_C.q * o.left_xy.homogeneous());
    }
    const Image black(320, 240, 2);
    const Image white(320, 240, 254);
    for (std::size_t k = 6; k < 12; ++k) {
        const Image& blind = k % 2 == 0 ? black : white;
        REQUIRE(ok(frontend.process({f.frames[k].stamp, blind.view(), blind.view()}, f.hints(k), out)));
        CHECK(out.image == (k % 2 == 0 ? ImageState::kDark : ImageState::kOverexposed));
        CHECK_FALSE(out.is_keyframe);
        CHECK(out.observations.empty());
    }
    const double off_px = GENERATE(0.0, 4.0);
    CAPTURE(off_px);
    FrameHints hints = f.hints(12);
    const auto predictions = f.predict(points, 12, Eigen::Vector2d(off_px, -off_px) / 200.0);
    test::GivenLandmarks landmarks(predictions);
    hints.landmarks = &landmarks;
    REQUIRE(ok(frontend.process(f.frames[12].view(), hints, out)));
    CHECK(out.is_keyframe);
    CHECK(out.recalled > static_cast<int>(points.size()) / 2);
    const Se3 T_C_W = (f.frames[12].T_W_B * f.rig.T_B_C0).inverse();
    for (const FeatureObservation& o : out.observations) {
        if (points.count(o.landmark) != 0) {
            const Eigen::Vector2d expected = (T_C_W * points.at(o.landmark)).hnormalized();
            CHECK((o.left_xy - expected).norm() * 200.0 < 0.3);
        }
    }
}

TEST_CASE("front-end forgets lost tracks whose landmarks the smoother has dropped", "[frontend]") {
    const FrontendConfig config = each_backend();
    CAPTURE(config.backend);
    const Flight& f = flight();
    Frontend frontend;
    REQUIRE(ok(frontend.configure(config, f.rig)));
    FrontendOutput out;
    REQUIRE(ok(frontend.process(f.frames[5].view(), f.hints(0), out)));
    const LandmarkId newest = out.observations.back().landmark;
    const Image black(320, 240, 0);
    REQUIRE(ok(frontend.process({f.frames[6].stamp, black.view(), black.view()}, f.hints(6), out)));
    FrameHints hints = f.hints(7);
    const LandmarkPrediction other{LandmarkId{newest.value + 1000}, false, Eigen::Vector2d::Zero(), 0.0};
    test::GivenLandmarks landmarks({&other, 1});
    hints.landmarks = &landmarks;
    hints.wants_keyframe = true;
    REQUIRE(ok(frontend.process(f.frames[7].view(), hints, out)));
    CHECK(out.recalled == 0);
    CHECK(out.is_keyframe);
    CHECK(out.observations.front().landmark > newest);
}

TEST_CASE("front-end distinguishes a frozen camera from a vehicle at rest", "[frontend]") {
    const FrontendConfig config = each_backend();
    CAPTURE(config.backend);
    const Flight& f = flight();
    Frontend frontend;
    REQUIRE(ok(frontend.configure(config, f.rig)));
    FrontendOutput out;
    REQUIRE(ok(frontend.process(f.frames[0].view(), f.hints(0), out)));
    REQUIRE(ok(frontend.process(f.frames[1].view(), f.hints(1), out)));  // the same picture, no turn
    CHECK(out.image == ImageState::kUsable);
    StereoFrame again = f.frames[0].view();
    again.stamp = f.frames[2].stamp;
    FrameHints turning = f.hints(2);
    turning.q_Bp_B = so3_exp({0.0, 0.01, 0.0});
    REQUIRE(ok(frontend.process(again, turning, out)));
    CHECK(out.image == ImageState::kFrozen);
    CHECK(out.observations.empty());
}

TEST_CASE("front-end works without the right image", "[frontend]") {
    const FrontendConfig config = each_backend();
    CAPTURE(config.backend);
    const Flight& f = flight();
    Frontend frontend;
    REQUIRE(ok(frontend.configure(config, f.rig)));
    FrontendOutput out;
    int keyframes = 0;
    for (std::size_t k = 0; k < 8; ++k) {
        StereoFrame frame = f.frames[k].view();
        frame.right = {};
        REQUIRE(ok(frontend.process(frame, f.hints(k), out)));
        CHECK(out.stereo == 0);
        CHECK(out.surface.empty());
        CHECK(out.observations.size() > 80);
        keyframes += out.is_keyframe ? 1 : 0;
    }
    CHECK(keyframes >= 1);
    int stereo = 0;
    for (std::size_t k = 8; k < 12; ++k) {
        REQUIRE(ok(frontend.process(f.frames[k].view(), f.hints(k), out)));
        stereo = std::max(stereo, out.stereo);
    }
    CHECK(stereo > 60);
}

TEST_CASE("front-end drops the tracks it is given, and resets", "[frontend]") {
    const FrontendConfig config = each_backend();
    CAPTURE(config.backend);
    const Flight& f = flight();
    Frontend frontend;
    REQUIRE(ok(frontend.configure(config, f.rig)));
    FrontendOutput out;
    REQUIRE(ok(frontend.process(f.frames[0].view(), f.hints(0), out)));
    const std::size_t before = out.observations.size();
    const LandmarkId dropped[] = {out.observations[3].landmark, out.observations[17].landmark, LandmarkId{99999},
                                  LandmarkId{}};
    frontend.drop_tracks(dropped);
    const LandmarkId newest = out.observations.back().landmark;
    REQUIRE(ok(frontend.process(f.frames[1].view(), f.hints(1), out)));
    CHECK(out.observations.size() == before - 2);
    for (const FeatureObservation& o : out.observations) {
        CHECK(o.landmark != dropped[0]);
        CHECK(o.landmark != dropped[1]);
    }
    frontend.reset();
    REQUIRE(ok(frontend.process(f.frames[0].view(), f.hints(0), out)));
    CHECK(out.is_keyframe);
    CHECK(out.tracked == 0);
    CHECK(out.observations.front().landmark > newest);
}

TEST_CASE("front-end says when landmark ids run out, in time, and counts from zero", "[frontend]") {
    const FrontendConfig config = each_backend();
    CAPTURE(config.backend);
    const Flight& f = flight();
    Frontend frontend;
    REQUIRE(ok(frontend.configure(config, f.rig)));
    FrontendOutput out;
    REQUIRE(ok(frontend.process(f.frames[0].view(), f.hints(0), out)));
    CHECK_FALSE(frontend.ids_run_out());
    frontend.restart_ids(LandmarkId::kInvalid - 10'000);
    CHECK(frontend.ids_run_out());
    for (std::size_t k = 1; k < 6; ++k) {  // there is still room for some keyframes
        REQUIRE(ok(frontend.process(f.frames[k].view(), f.hints(k), out)));
        for (const FeatureObservation& o : out.observations) {
            CHECK(o.landmark.valid());
            CHECK(o.landmark.value >= LandmarkId::kInvalid - 10'000);
        }
    }
    frontend.restart_ids();
    CHECK_FALSE(frontend.ids_run_out());
    REQUIRE(ok(frontend.process(f.frames[6].view(), f.hints(6), out)));
    CHECK(out.is_keyframe);
    CHECK(out.observations.front().landmark.value == 0);
}

TEST_CASE("front-end refuses configurations out of range", "[frontend]") {
    const StereoRig rig = synthetic::make_rig();
    Frontend frontend;
    const auto refused = [&](auto change) {
        FrontendConfig config = small_config();
        change(config);
        return frontend.configure(config, rig) == Status::kInvalidArgument;
    };
    CHECK(refused([](FrontendConfig& c) { c.max_features = 513; }));
    CHECK(refused([](FrontendConfig& c) { c.surface_points = 385; }));
    CHECK(refused([](FrontendConfig& c) { c.surface_points = -1; }));
    CHECK(refused([](FrontendConfig& c) { c.window_px = 16; }));
    CHECK(refused([](FrontendConfig& c) { c.pyramid_levels = 1; }));
    CHECK(refused([](FrontendConfig& c) { c.pyramid_levels = 6; }));  // 320x240 cannot be halved so often
    CHECK(refused([](FrontendConfig& c) { c.min_depth_m = std::numeric_limits<double>::quiet_NaN(); }));
    CHECK(refused([](FrontendConfig& c) { c.keyframe_max_interval_s = 0.1; }));
    CHECK(refused([](FrontendConfig& c) { c.backend = 2; }));
    FrontendConfig opencv = small_config();
    opencv.backend = 1;
    CHECK(ok(frontend.configure(opencv, rig)) == has_opencv_engine());
    CHECK(opencv.broken_rule().empty() == has_opencv_engine());
    StereoRig same_place = rig;
    same_place.T_B_C1.p = rig.T_B_C0.p;
    CHECK(frontend.configure(small_config(), same_place) == Status::kInvalidArgument);
    CHECK(ok(frontend.configure(small_config(), rig)));
}

}  // namespace facet::frontend_test
