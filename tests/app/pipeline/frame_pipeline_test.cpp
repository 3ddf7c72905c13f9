// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/frame_pipeline.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "tests/support/still_vehicle.h"

namespace facet::frame_pipeline_test {
namespace {

TEST_CASE("an estimate comes before the mesh of its keyframe, and in two steps all is as in one") {
    const test::StillVehicle vehicle;
    Calibration calibration;
    calibration.rig = vehicle.rig;
    const auto whole = std::make_unique<FramePipeline>();
    const auto halves = std::make_unique<FramePipeline>();
    whole->configure({}, calibration);
    halves->configure({}, calibration);
    FrameResult a;
    FrameResult b;
    int sample = 0;
    int meshes = 0;
    for (int k = 0; k < 30; ++k) {
        // A frame ahead: what is found of the clocks' offset, which nothing tells here, may put the frame's time later.
        for (; sample <= 30 + 10 * k; ++sample) {
            const ImuSample s{test::at(0.005 * sample), {0.001, -0.002, 0.003}, {0.0, 0.0, 9.81}};
            whole->add_imu(s);
            halves->add_imu(s);
        }
        const StereoFrame frame = vehicle.moved_frame(0.1 + 0.05 * k, k);
        whole->add_frame(frame, frame.stamp, a);
        REQUIRE(a.status == Status::kOk);
        halves->estimate_frame(frame, frame.stamp, b);
        CHECK(b.estimate.state.p_W_B == a.estimate.state.p_W_B);
        CHECK(b.estimate.covariance == a.estimate.covariance);
        CHECK_FALSE(b.has_mesh);
        CHECK(halves->departed().empty());
        halves->finish_frame(frame, b);
        REQUIRE(b.has_mesh == a.has_mesh);
        CHECK(b.timing.estimate.wall_ms <= b.timing.total.wall_ms);
        if (a.has_mesh) {
            ++meshes;
            CHECK(b.mesh_faces == a.mesh_faces);
            CHECK(b.mesh_vertices == a.mesh_vertices);
            CHECK(b.planes.size() == a.planes.size());
        }
    }
    CHECK(meshes >= 2);
    CHECK(a.mesh.updates > 1);
}

TEST_CASE("a mesh that comes two frames later is that of its keyframe, whose images are gone by then") {
    const test::StillVehicle vehicle;
    Calibration calibration;
    calibration.rig = vehicle.rig;
    const auto pipeline = std::make_unique<FramePipeline>();
    pipeline->configure({}, calibration);
    std::vector<std::uint8_t> left(752U * 480U);
    std::vector<std::uint8_t> right(752U * 480U);
    const auto fill = [](const ImageView& image, std::vector<std::uint8_t>& pixels) {
        for (int v = 0; v < image.height; ++v) {
            std::copy_n(image.row(v), image.width, pixels.begin() + v * image.width);
        }
        return ImageView{pixels.data(), image.width, image.height, image.width};
    };
    constexpr int kStep_px = 4;
    constexpr double kBegin_s = 0.5;
    constexpr double kFrame_s = 0.05;
    FrameResult result;
    int sample = 0;
    int keyframes = 0;
    int meshes = 0;
    int late_meshes = 0;
    std::uint64_t updates = 0;
    for (int k = 0; k < 60; ++k) {
        for (; sample <= 110 + 10 * k; ++sample) {
            pipeline->add_imu({test::at(0.005 * sample), {0.001, -0.002, 0.003}, {0.0, 0.0, 9.81}});
        }
        const StereoFrame seen = vehicle.moved_frame(kBegin_s + kFrame_s * k, kStep_px * k);
        const StereoFrame frame{seen.stamp, fill(seen.left, left), fill(seen.right, right)};
        pipeline->add_frame(frame, frame.stamp, result);
        REQUIRE(result.status == Status::kOk);
        keyframes += result.is_keyframe && result.is_usable ? 1 : 0;
        if (!result.has_mesh) {
            continue;
        }
        ++meshes;
        CHECK(result.mesh.updates == updates + 1);
        updates = result.mesh.updates;
        const MappedKeyframe& mapped = pipeline->mapped();
        CHECK(result.mesh_frame_stamp == mapped.frame.stamp);
        const auto late = static_cast<int>(std::lround((frame.stamp - mapped.frame.stamp).seconds() / kFrame_s));
        CHECK((late == 0 || late == 2));
        CHECK((late == 0) == result.is_keyframe);
        late_meshes += late == 2 ? 1 : 0;
        const StereoFrame as_it_was = vehicle.moved_frame(0.0, kStep_px * (k - late));
        CHECK(mapped.frame.left.at(100, 200) == as_it_was.left.at(100, 200));
        CHECK(mapped.frame.right.at(600, 300) == as_it_was.right.at(600, 300));
        CHECK(pipeline->keyframe_view().stamp == mapped.estimate_stamp);
    }
    CHECK(late_meshes > 4);
    CHECK(meshes >= keyframes - 2);  // the first one has none, that of the last one may be to come
}

}  // namespace
}  // namespace facet::frame_pipeline_test
