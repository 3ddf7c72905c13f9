// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/frame_pipeline.h"

#include <catch2/catch.hpp>
#include <memory>

#include "tests/support/still_vehicle.h"

namespace facet {
namespace {

TEST_CASE("frames from before a clock's step back are refused, DEGRADED at first and then LOST") {
    const test::StillVehicle vehicle;
    Calibration calibration;
    calibration.rig = vehicle.rig;
    const auto pipeline = std::make_unique<FramePipeline>();
    pipeline->configure({}, calibration);
    FrameResult result;
    int sample = 0;
    for (int k = 0; k < 4; ++k) {
        for (; sample <= 20 + 10 * k; ++sample) {
            pipeline->add_imu({test::at(0.005 * sample), {0.001, -0.002, 0.003}, {0.0, 0.0, 9.81}});
        }
        const StereoFrame frame = vehicle.frame(0.1 + 0.05 * k);
        pipeline->add_frame(frame, frame.stamp, result);
        REQUIRE(result.status == Status::kOk);
    }
    REQUIRE(result.estimate.health.state == TrackingState::kTracking);
    const double lost_after_s = ProgramConfig{}.health.lost_after_s;
    for (int k = 0; 0.05 * k < lost_after_s + 0.5; ++k) {
        const StereoFrame frame = vehicle.frame(-900.0 + 0.05 * k);
        pipeline->add_frame(frame, frame.stamp, result);
        INFO(0.05 * k << " s after the first of them");
        REQUIRE(result.status == Status::kOutOfOrder);
        REQUIRE_FALSE(result.is_usable);
        const bool is_long = 0.05 * k > lost_after_s + 1e-6;
        CHECK(result.estimate.health.state == (is_long ? TrackingState::kLost : TrackingState::kDegraded));
        CHECK((result.estimate.health.quality == 0) == is_long);
    }
}

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

}  // namespace
}  // namespace facet
