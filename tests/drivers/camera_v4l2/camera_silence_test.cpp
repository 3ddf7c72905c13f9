// SPDX-License-Identifier: BSD-2-Clause
// Cameras that give nothing, or nothing good.
#include <catch2/catch.hpp>

#include "tests/drivers/camera_v4l2/camera_harness.h"

namespace facet::camera_silence_test {
namespace {

TEST_CASE("one frame stamped in the future is refused and does not keep out the frames after it") {
    CameraV4l2Harness h(false, judged_options());
    REQUIRE(ok(h.camera.start()));
    CHECK(run_camera(h, 1.0) == 20);
    h.kernel.stamp_error_ns = 3'600'000'000'000;
    CHECK(run_camera(h, 0.05) == 0);
    h.kernel.stamp_error_ns = 0;
    CHECK(run_camera(h, 60.0) == 1200);
    CHECK(h.camera.camera_counters().stamps_refused == 1);
    CHECK(h.camera.counters().errors == 0);
}

TEST_CASE("a camera none of whose frames can be used is reported with the reason, and reopened") {
    struct Case {
        std::int64_t stamp_error_ns;
        std::uint32_t flags;
        std::uint32_t cut;
        const char* why;
    };
    const Case cases[] = {{3'600'000'000'000, 0, 0, "stamps in the future"},
                          {-140'000'000'000'000'000, 0, 0, "stamps of long ago"},
                          {0, V4L2_BUF_FLAG_ERROR, 0, "the driver marks every buffer as bad"},
                          {0, 0, 1, "every buffer is too short"}};
    for (const Case& c : cases) {
        CAPTURE(c.why);
        CameraV4l2Harness h(false, judged_options());
        REQUIRE(ok(h.camera.start()));
        CHECK(run_camera(h, 1.0) == 20);
        const int opened = h.kernel.opened;
        h.kernel.stamp_error_ns = c.stamp_error_ns;
        CHECK(run_camera(h, 60.0, c.flags, c.cut) == 0);
        CHECK(h.camera.problem().find(std::string("ms: ") + c.why) != std::string_view::npos);
        CHECK(h.camera.counters().errors == 1);
        CHECK(h.kernel.opened > opened + 20);
        h.kernel.stamp_error_ns = 0;
        CHECK(run_camera(h, 3.0) >= 40);
        CHECK(h.camera.counters().recoveries == 1);
    }
}

TEST_CASE("a camera whose stamps stand still is reopened") {
    CameraV4l2Harness h(false, judged_options());
    REQUIRE(ok(h.camera.start()));
    CHECK(run_camera(h, 1.0) == 20);
    const std::int64_t stands_ns = h.clock.now().ns;
    int delivered = 0;
    for (int i = 0; i < 100; ++i) {
        h.clock.advance(Duration::from_seconds(0.05));
        h.kernel.expose(1, stands_ns);
        CameraFrame frame;
        delivered += ok(h.camera.next({}, frame)) ? 1 : 0;
        (void)h.camera.next({}, frame);
    }
    CHECK(delivered == 0);
    CHECK(h.camera.counters().errors == 1);
    CHECK(h.camera.problem() == "/dev/video0: no good data for 2050 ms: stamps that do not increase");
}

TEST_CASE("a consumer that holds every slot is no reason to reopen the camera") {
    CameraV4l2Harness h(false, judged_options());
    REQUIRE(ok(h.camera.start()));
    std::vector<CameraFrame> held;
    for (std::size_t i = 0; i < CameraV4l2::kSlots; ++i) {
        h.stamp_ns += 50'000'000;
        h.kernel.expose(1, h.stamp_ns);
        CameraFrame frame;
        REQUIRE(h.camera.next({}, frame) == Status::kOk);
        held.push_back(std::move(frame));
        (void)h.camera.next({}, frame);
    }
    CHECK(run_camera(h, 10.0) == 0);
    CHECK(h.camera.camera_counters().no_slot == 200);
    CHECK(h.camera.counters().errors == 0);
}

TEST_CASE("a node that is there but gives no more images is reopened, also when that does not help at first") {
    CameraV4l2Options options = small_options();
    options.silence = Duration::from_seconds(0.5);
    CameraV4l2Harness h(false, options);
    REQUIRE(ok(h.camera.start()));
    CameraFrame frame;
    const auto run = [&](double seconds, bool exposing) {
        int frames = 0;
        for (int i = 0; i < static_cast<int>(seconds * 20.0 + 0.5); ++i) {
            h.waiting = exposing ? 1 : 0;
            h.expose_one();
            frames += ok(h.camera.next({}, frame)) ? 1 : 0;
            frame = {};
            h.clock.advance(Duration::from_seconds(0.05));
        }
        return frames;
    };
    CHECK(run(1.0, true) == 20);
    const int opened = h.kernel.opened;
    // A dead sensor behind a bridge that lives: never an error, never an image.
    CHECK(run(0.7, false) == 0);
    CHECK(h.kernel.opened == opened + 1);
    CHECK(h.camera.problem() == "/dev/video0: no data for 550 ms");
    CHECK(run(5.0, false) == 0);
    CHECK(h.kernel.opened == opened + 3);
    CHECK(h.camera.counters().errors == 1);
    CHECK(run(1.0, true) >= 19);
    CHECK(h.camera.counters().recoveries == 1);
    CHECK(h.kernel.mapped > 0);
}

}  // namespace
}  // namespace facet::camera_silence_test
