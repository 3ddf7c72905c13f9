// SPDX-License-Identifier: BSD-2-Clause
// What the stages of the front-end cost on synthetic images: two distorted cameras of 752x480 before a wall, and whole
// frames with other sizes too.
#include <benchmark/benchmark.h>

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "estimator/frontend/corner_score.h"
#include "estimator/frontend/detector.h"
#include "estimator/frontend/frontend.h"
#include "estimator/frontend/image_check.h"
#include "estimator/frontend/outlier_test.h"
#include "estimator/frontend/stereo_matcher.h"
#include "estimator/frontend/tracker.h"
#include "tests/estimator/frontend/synthetic.h"

using namespace facet;

namespace {

constexpr int kFrames = 8;
constexpr int kWidth = 752;
constexpr int kHeight = 480;

/// The synthetic rig with images of this width and the sides of 752x480.
StereoRig rig_of_width(int width) {
    const StereoRig half = synthetic::make_rig();
    const double scale = static_cast<double>(width) / kWidth;
    const auto enlarged = [&](const CameraModel& camera) {
        CameraIntrinsics k = camera.intrinsics();
        k.width = width;
        k.height = width * kHeight / kWidth;
        k.fx *= 2.3 * scale;
        k.fy *= 2.3 * scale;
        k.cx *= 2.35 * scale;
        k.cy *= 2.0 * scale;
        return CameraModel(k);
    };
    return {enlarged(half.left), enlarged(half.right), half.T_B_C0, half.T_B_C1};
}

/// A flight along a slanted wall with texture at all scales, rendered once.
struct Scene {
    StereoRig rig;
    std::vector<Se3> poses;
    std::vector<synthetic::Image> left;
    std::vector<synthetic::Image> right;

    explicit Scene(int width) : rig(rig_of_width(width)) {
        const synthetic::Plane wall{Eigen::Vector3d(0.1, -0.2, 1.0).normalized(), 3.0};
        const synthetic::Texture texture(0.06, 1.0, 41);
        for (int k = 0; k < kFrames; ++k) {
            const double s = 0.05 * k;
            poses.push_back({so3_exp({0.3 * s, -0.2 * s, -1.5 + 0.4 * s}), {0.5 * s, -0.2 * s, 0.3 * s}});
            left.push_back(synthetic::render(wall, texture, rig.left, poses.back() * rig.T_B_C0));
            right.push_back(synthetic::render(wall, texture, rig.right, poses.back() * rig.T_B_C1));
        }
    }
    StereoFrame frame(int k, int count) const {
        const auto i = static_cast<std::size_t>(k);
        return {Timestamp{} + Duration::from_seconds(1.0 + 0.05 * count), left[i].view(), right[i].view()};
    }
};

const Scene& scene(int width = kWidth) {
    static std::map<int, std::unique_ptr<const Scene>> scenes;
    std::unique_ptr<const Scene>& scene = scenes[width];
    if (scene == nullptr) {
        scene = std::make_unique<const Scene>(width);
    }
    return *scene;
}

ImagePyramid pyramid_of(const synthetic::Image& image) {
    ImagePyramid pyramid;
    (void)pyramid.configure(image.width, image.height, FrontendConfig{}.pyramid_levels);
    pyramid.build(image.view());
    return pyramid;
}

CameraModel pinhole(const synthetic::Image& image) {
    return CameraModel(
        {image.width, image.height, 458.0, 458.0, 0.5 * image.width, 0.5 * image.height, Distortion::kNone, {}});
}

CornerList corners_of(const synthetic::Image& image, double border_px) {
    Detector detector;
    detector.configure(FrontendConfig{}, pinhole(image), border_px);
    CornerList corners;
    detector.detect(image.view(), {}, FrontendConfig{}.max_features, corners);
    return corners;
}

void pyramid(benchmark::State& state) {
    ImagePyramid pyramid = pyramid_of(scene().left[0]);
    for (auto _ : state) {
        pyramid.build(scene().left[0].view());
    }
}
BENCHMARK(pyramid)->Unit(benchmark::kMicrosecond);

void image_check(benchmark::State& state) {
    const ImagePyramid pyramid = pyramid_of(scene().left[0]);
    for (auto _ : state) {
        benchmark::DoNotOptimize(check_image(pyramid.level(pyramid.levels() - 1)));
    }
}
BENCHMARK(image_check)->Unit(benchmark::kMicrosecond);

void corner_score(benchmark::State& state) {
    CornerScore score;
    score.configure(scene().left[0].width, scene().left[0].height);
    for (auto _ : state) {
        score.compute(scene().left[0].view());
    }
}
BENCHMARK(corner_score)->Unit(benchmark::kMicrosecond);

void detector(benchmark::State& state) {
    Detector detector;
    detector.configure(FrontendConfig{}, scene().rig.left, 9.0);
    CornerList corners;
    for (auto _ : state) {
        corners.clear();
        detector.detect(scene().left[0].view(), {}, 300, corners);
    }
    state.counters["corners"] = static_cast<double>(corners.size());
}
BENCHMARK(detector)->Unit(benchmark::kMicrosecond);

void template_extraction(benchmark::State& state) {
    const ImagePyramid image = pyramid_of(scene().left[0]);
    const FrontendConfig config;
    PatchAligner aligner;
    (void)aligner.configure(config.window_px, config.pyramid_levels, FrontendConfig::kLkIterations,
                            FrontendConfig::kLkEpsilon_px);
    PatchTemplate patch;
    aligner.allocate(patch);
    const CornerList corners = corners_of(scene().left[0], aligner.border_px());
    std::size_t i = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(aligner.extract(image, corners[i++ % corners.size()], {2, true}, patch));
    }
}
BENCHMARK(template_extraction)->Unit(benchmark::kMicrosecond);

/// One track, backward check included.
void follow_track(benchmark::State& state) {
    const ImagePyramid before = pyramid_of(scene().left[0]);
    const ImagePyramid now = pyramid_of(scene().left[1]);
    const StereoRig& rig = scene().rig;
    const auto tracker = std::make_unique<Tracker>();
    (void)tracker->configure(FrontendConfig{}, rig.left);
    std::vector<Track> tracks;
    for (const Eigen::Vector2d& corner : corners_of(scene().left[0], tracker->border_px())) {
        Track track;
        if (ok(tracker->start(before, corner, track))) {
            tracks.push_back(track);
        }
    }
    const Eigen::Quaterniond q_Bp_B = scene().poses[0].q.conjugate() * scene().poses[1].q;
    const FrameMotion motion{(rig.T_B_C0.q.conjugate() * q_Bp_B.conjugate() * rig.T_B_C0.q).normalized(), 0.05};
    std::size_t i = 0;
    double found = 0.0;
    for (auto _ : state) {
        Track track = tracks[i++ % tracks.size()];
        found += ok(tracker->follow(before, now, motion, track)) ? 1.0 : 0.0;
    }
    state.counters["found"] = found / static_cast<double>(i);
}
BENCHMARK(follow_track)->Unit(benchmark::kMicrosecond);

/// One point; argument 1: its depth is known.
void stereo_match(benchmark::State& state) {
    const ImagePyramid left = pyramid_of(scene().left[0]);
    const ImagePyramid right = pyramid_of(scene().right[0]);
    StereoMatcher matcher;
    (void)matcher.configure(FrontendConfig{}, scene().rig);
    const CornerList corners = corners_of(scene().left[0], 9.0);
    std::size_t i = 0;
    double matched = 0.0;
    for (auto _ : state) {
        StereoMatch match;
        const double known = state.range(0) != 0 ? 0.33 : -1.0;
        matched += ok(matcher.match(left, right, corners[i++ % corners.size()], known, match)) ? 1.0 : 0.0;
    }
    state.counters["matched"] = matched / static_cast<double>(i);
}
BENCHMARK(stereo_match)->ArgName("known")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

/// 250 points of which a tenth are wrong.
void mono_outliers(benchmark::State& state) {
    OutlierTest test;
    test.configure(FrontendConfig{}, scene().rig);
    std::mt19937 random(3);
    const auto uniform = [&random](double reach) {
        return reach * (static_cast<double>(random()) / 2147483648.0 - 1.0);
    };
    std::vector<MonoPair> pairs;
    for (int i = 0; i < 250; ++i) {
        const Eigen::Vector3d p(uniform(2.0), uniform(1.5), 4.0 + uniform(2.0));
        Eigen::Vector3d q = p + Eigen::Vector3d(0.1, 0.02, -0.05);
        if (i % 10 == 0) {
            q += Eigen::Vector3d(uniform(0.2), uniform(0.2), 0.0);
        }
        pairs.push_back({p / p.z(), q.hnormalized()});
    }
    std::vector<std::uint8_t> inlier(pairs.size());
    for (auto _ : state) {
        benchmark::DoNotOptimize(test.mono(pairs, inlier));
    }
}
BENCHMARK(mono_outliers)->Unit(benchmark::kMicrosecond);

void stereo_outliers(benchmark::State& state) {
    OutlierTest test;
    test.configure(FrontendConfig{}, scene().rig);
    std::mt19937 random(3);
    const auto uniform = [&random](double reach) {
        return reach * (static_cast<double>(random()) / 2147483648.0 - 1.0);
    };
    std::vector<StereoPair> pairs;
    for (int i = 0; i < 200; ++i) {
        const Eigen::Vector3d p(uniform(2.0), uniform(1.5), 4.0 + uniform(2.0));
        const double slip = i % 10 == 0 ? 0.5 : 0.0;
        pairs.push_back({p, p + Eigen::Vector3d(0.1 + uniform(slip), 0.02 + uniform(slip), -0.05)});
    }
    std::vector<std::uint8_t> inlier(pairs.size());
    for (auto _ : state) {
        benchmark::DoNotOptimize(test.stereo(pairs, Eigen::Matrix3d::Identity(), inlier));
    }
}
BENCHMARK(stereo_outliers)->Unit(benchmark::kMicrosecond);

/// Whole frames, there and back along the flight. Arguments: whether every frame is a keyframe, width of the images.
void whole_frame(benchmark::State& state) {
    const Scene& flight = scene(static_cast<int>(state.range(1)));
    FrontendConfig config;
    const bool all_keyframes = state.range(0) != 0;
    config.keyframe_max_interval_s = 5.0;
    config.keyframe_disparity_px = 100.0;
    Frontend frontend;
    (void)frontend.configure(config, flight.rig);
    int count = 0;
    int place = 0;
    int step = 1;
    double tracks = 0.0;
    FrontendOutput output;
    for (auto _ : state) {
        FrameHints hints;
        hints.wants_keyframe = all_keyframes;
        if (count > 0) {
            step = place + step < 0 || place + step >= kFrames ? -step : step;
            hints.q_Bp_B = flight.poses[static_cast<std::size_t>(place)].q.conjugate() *
                           flight.poses[static_cast<std::size_t>(place + step)].q;
            place += step;
        }
        (void)frontend.process(flight.frame(place, count++), hints, output);
        tracks += static_cast<double>(output.observations.size());
    }
    state.counters["tracks"] = tracks / count;
}
BENCHMARK(whole_frame)
    ->ArgNames({"keyframes", "width"})
    ->ArgsProduct({{0, 1}, {376, 564, kWidth, 1128}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
