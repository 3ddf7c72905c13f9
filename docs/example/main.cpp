// SPDX-License-Identifier: BSD-2-Clause
// Estimator, mesher and plane finder in a program of your own. Its vehicle stands two metres in front of a wall.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "estimator/api/estimator.h"
#include "mesh/mesher.h"
#include "mesh/planes/plane_finder.h"

constexpr int kWidth = 640, kHeight = 480, kFocal = 400;        // of both cameras (px), which are 0.1 m apart
constexpr int kDisparity = 20, kColumns = kWidth + kDisparity;  // of a wall 2 m away (px), and columns of its picture

/// Squares of 10 x 10 px in random grey: a pixel equals the one above or to the left unless a square begins with it.
std::vector<std::uint8_t> make_wall() {
    std::mt19937 random(1);
    std::vector<std::uint8_t> wall(kColumns * kHeight);
    for (int i = 0; i < kColumns * kHeight; ++i) {
        const int u = i % kColumns, v = i / kColumns;
        wall[i] = v % 10 > 0 ? wall[i - kColumns] : u % 10 > 0 ? wall[i - 1] : random() % 256;
    }
    return wall;
}

/// Copies of a frame's images. A keyframe's view comes up to two frames later, when a camera's own buffers hold others.
struct KeptFrame {
    facet::Timestamp stamp;
    std::array<std::vector<std::uint8_t>, 2> pixels;  // left, right

    void keep(const facet::StereoFrame& frame) {
        stamp = frame.stamp;
        for (const bool is_right : {false, true}) {
            const facet::ImageView& image = is_right ? frame.right : frame.left;
            pixels[is_right].clear();
            for (int v = 0; v < image.height; ++v) {
                pixels[is_right].insert(pixels[is_right].end(), image.row(v), image.row(v) + image.width);
            }
        }
    }
    /// Empty if there was no such image.
    facet::ImageView image(bool is_right) const {
        return pixels[is_right].empty() ? facet::ImageView{}
                                        : facet::ImageView{pixels[is_right].data(), kWidth, kHeight, kWidth};
    }
};

int main() {
    // Body frame (IMU): x forward, y left, z up. Camera frames: z forward, x right, y down.
    const facet::CameraModel camera({kWidth, kHeight, kFocal, kFocal, 0.5 * (kWidth - 1), 0.5 * (kHeight - 1)});
    const Eigen::Quaterniond q_B_C(0.5, -0.5, 0.5, -0.5);  // w, x, y, z
    const facet::StereoRig rig{camera, camera, {q_B_C, {0.0, 0.05, 0.0}}, {q_B_C, {0.0, -0.05, 0.0}}};
    facet::EstimatorConfig config;  // the defaults, but planes become part of the estimate
    config.regularity.mode = facet::RegularityMode::kSpr;
    facet::Estimator estimator;
    static facet::Mesher mesher;  // 2 MB, and the finder has 1 MB: too much for the stack
    static facet::PlaneFinder finder;
    if (!ok(estimator.configure(config, rig)) || !ok(mesher.configure({}, rig.left)) || !ok(finder.configure({}))) {
        return 1;
    }
    const std::vector<std::uint8_t> wall = make_wall();
    const facet::ImageView left{wall.data(), kWidth, kHeight, kColumns};
    const facet::ImageView right{wall.data() + kDisparity, kWidth, kHeight, kColumns};
    facet::Estimate estimate;
    std::array<KeptFrame, 4> kept;  // the newest frames
    std::size_t frames = 0;
    std::uint32_t last_view = 0;
    for (std::int64_t i = 0; i < 1000; ++i) {  // five seconds at rest: inertial samples at 200 Hz, frames at 20 Hz
        const facet::Timestamp now{i * 5'000'000};
        const facet::Status sampled = estimator.add_imu({now, {0.0, 0.0, 0.0}, {0.0, 0.0, 9.81}});
        const facet::StereoFrame frame{now - facet::Duration{2'000'000}, left, right};  // samples reach beyond it
        if (!ok(sampled) || i % 10 != 0 || !ok(estimator.add_frame(frame, estimate))) {
            continue;
        }
        kept[frames++ % kept.size()].keep(frame);
        estimator.finish_frame();
        const facet::KeyframeView& view = estimator.keyframe_view();
        if (view.number != last_view) {  // a new keyframe: landmarks give faces, faces give planes, and those go back
            last_view = view.number;
            const KeptFrame& seen = *std::ranges::min_element(
                kept, {}, [&](const KeptFrame& k) { return std::abs((k.stamp - view.stamp).ns); });
            mesher.set_camera(view.is_exchanged ? rig.right : rig.left);  // the left camera fails: the right one saw it
            mesher.update(view, seen.image(view.is_exchanged));
            estimator.set_planes(finder.update(mesher.mesh(), view));
        }
    }
    const Eigen::Vector3d& p = estimate.state.p_W_B;
    std::printf("%s at (%.3f, %.3f, %.3f) m; faces: %d, planes: %zu\n", to_string(estimate.health.state), p.x(), p.y(),
                p.z(), mesher.mesh().face_count(), finder.proposals().size());
}
