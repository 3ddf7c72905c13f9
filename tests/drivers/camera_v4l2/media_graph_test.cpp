// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/media_graph.h"

#include <catch2/catch.hpp>

#include "drivers/camera_v4l2/camera_v4l2.h"
#include "tests/drivers/camera_v4l2/fake_media.h"

namespace facet::media_graph_test {
namespace {

struct Bridge {
    ManualClock clock{{1'000'000'000}};
    test::FakeMedia kernel{clock};

    /// Starts a camera on it, of which the rest is as in every test of cameras.
    Status start(std::string& problem) {
        CameraV4l2Options options;
        options.capture.width = 8;
        options.capture.height = 4;
        CameraV4l2 camera(kernel, clock, options);
        const Status status = camera.start();
        problem = camera.problem();
        if (ok(status)) {
            kernel.camera.expose(77, 2'000'000'000);
            CameraFrame frame;
            CHECK(camera.next({}, frame) == Status::kOk);
            CHECK(frame.image.at(7, 3) == 77);
        }
        camera.stop();
        CHECK(kernel.open_nodes == 0);
        return status;
    }
    std::string refusal() {
        std::string problem;
        CHECK_FALSE(ok(start(problem)));
        return problem;
    }
};

TEST_CASE("a sensor behind a media device is set up, link by link, before streaming begins") {
    Bridge bridge;
    REQUIRE_FALSE(bridge.kernel.fits());
    std::string problem;
    CHECK(bridge.start(problem) == Status::kOk);
    CHECK(problem.empty());
    CHECK(bridge.kernel.fits());
    CHECK(bridge.kernel.links_enabled == 0);
}

TEST_CASE("the only link into a part is enabled; of several, somebody must have chosen") {
    Bridge bridge;
    bridge.kernel.is_linked = false;
    std::string problem;
    CHECK(bridge.start(problem) == Status::kOk);
    CHECK(bridge.kernel.links_enabled == 1);

    Bridge two;
    two.kernel.is_linked = false;
    two.kernel.has_second = true;
    CHECK(two.refusal() ==
          "/dev/video0: /dev/media1 'csi2': none of 2 links to it is enabled: choose one with media-ctl");
    Bridge chosen;
    chosen.kernel.has_second = true;
    CHECK(chosen.start(problem) == Status::kOk);
}

TEST_CASE("a receiver that its driver sets itself needs no node of its own") {
    Bridge bridge;
    bridge.kernel.has_receiver_node = false;
    bridge.kernel.validates = false;
    std::string problem;
    CHECK(bridge.start(problem) == Status::kOk);
    CHECK(bridge.kernel.pads[0] == test::FakeBusFormat{MEDIA_BUS_FMT_Y8_1X8, 8, 4});
}

TEST_CASE("what cannot be set up is named by its part, and nothing stays open") {
    Bridge sensor;
    sensor.kernel.sensor_code = MEDIA_BUS_FMT_Y10_1X10;
    CHECK(
        sensor.refusal() ==
        "/dev/video0: /dev/media1 'ov9281 10-0060': gives 1920x1080 in bus format 0x3007 instead of 8x4 in bus format "
        "0x2001");
    Bridge narrow;
    narrow.kernel.receiver_widest = 6;
    CHECK(narrow.refusal() ==
          "/dev/video0: /dev/media1 'csi2': takes 6x4 in bus format 0x2001, not 8x4 in bus format 0x2001");
    Bridge nowhere;
    nowhere.kernel.has_media = false;
    CHECK(nowhere.refusal() ==
          "/dev/video0: its images come through a media device, but none that can be opened (/dev/media*) has it");
}

TEST_CASE("streaming that is refused says where to look") {
    Bridge bridge;
    bridge.kernel.camera.on_stream = [] { return -EPIPE; };
    CHECK(bridge.refusal() ==
          "/dev/video0: streaming does not start, because the formats or links between sensor and node do not fit "
          "(media-ctl --print-topology shows them): Broken pipe");
    Bridge other;
    other.kernel.camera.on_stream = [] { return -EIO; };
    CHECK(other.refusal() == "/dev/video0: streaming does not start: Input/output error");
}

}  // namespace
}  // namespace facet::media_graph_test
