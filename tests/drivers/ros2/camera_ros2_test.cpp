// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/camera_ros2.h"

#include <catch2/catch.hpp>
#include <string>
#include <utility>

#include "tests/drivers/ros2/fake_ros2.h"
#include "tests/port_conformance/source_conformance.h"
#include "tests/support/jpeg_images.h"
#include "tests/support/scripted_source.h"

namespace facet::camera_ros2_test {
namespace {

constexpr Duration kRealtimeOffset = Duration::from_seconds(1.7e9);
constexpr Duration kPeriod = Duration::from_seconds(0.05);

CameraRos2Options tiny_options() {
    CameraRos2Options options;
    options.topic = "/left/image_rect_raw";
    options.width = 4;
    options.height = 2;
    options.silence = Duration::from_seconds(1.0);
    return options;
}

class CameraRos2Harness final : public test::CameraHarness {
public:
    explicit CameraRos2Harness(CameraRos2Options options = tiny_options()) : camera(node, clock, std::move(options)) {}

    CameraSource& source() override { return camera; }
    void offer(int count) override {
        for (int i = 0; i < count; ++i) {
            clock.advance(kPeriod);
            add("mono8", std::vector<std::uint8_t>(8, static_cast<std::uint8_t>(i)), clock.read_pair().realtime);
        }
    }
    test::Hook offer_corrupt() override {
        clock.advance(kPeriod);
        add("bayer_rggb16", std::vector<std::uint8_t>(8), clock.read_pair().realtime);
        return test::Hook::kDone;
    }
    test::Hook offer_ahead() override {
        add("mono8", std::vector<std::uint8_t>(8), clock.read_pair().realtime + Duration::from_seconds(3600.0));
        return test::Hook::kDone;
    }
    test::Hook break_device() override {
        node.graph.is_broken = true;
        return test::Hook::kDone;
    }
    void repair_device() override { node.graph.is_broken = false; }
    test::Hook judges_silence() override { return test::Hook::kDone; }
    test::Hook end() override { return test::Hook::kCannot; }
    void pass_time() override { clock.advance(Duration::from_seconds(0.6)); }
    int held_back() const override { return 0; }

    void add(const char* encoding, std::vector<std::uint8_t> data, Timestamp stamp) {
        test::FakeImage image;
        image.encoding = encoding;
        image.data = std::move(data);
        image.image.stamp = stamp;
        image.image.width = image.image.step = 4;
        image.image.height = 2;
        node.graph.images.push_back(std::move(image));
    }

    ManualClock clock{{1'000'000'000}, kRealtimeOffset};
    test::FakeNode node;
    CameraRos2 camera;
};

TEST_CASE("a camera on a topic keeps the contract of sources") {
    test::check_source_conformance<test::CameraHarness>([] { return std::make_unique<CameraRos2Harness>(); });
}

TEST_CASE("an image is delivered at the middle of its exposure, in a slot of its own") {
    CameraRos2Options options = tiny_options();
    options.latency = Duration::from_seconds(0.004);
    CameraRos2Harness h(options);
    REQUIRE(ok(h.camera.start()));
    CHECK(h.camera.clock() == ClockDomain::kRealtime);
    h.add("mono8", {1, 2, 3, 4, 5, 6, 7, 8}, h.clock.read_pair().realtime);
    h.clock.advance(kPeriod);
    CameraFrame first;
    REQUIRE(ok(h.camera.next({}, first)));
    CHECK(first.stamp == Timestamp{1'000'000'000} + kRealtimeOffset - options.latency);
    CHECK(first.image.at(3, 1) == 8);
    std::vector<CameraFrame> held(CameraRos2::kSlots - 1);
    h.offer(static_cast<int>(CameraRos2::kSlots));
    for (CameraFrame& frame : held) {
        REQUIRE(ok(h.camera.next({}, frame)));
    }
    CameraFrame none;
    CHECK(h.camera.next({}, none) == Status::kNotReady);
    CHECK(h.camera.camera_counters().no_slot == 1);
    CHECK(first.image.at(3, 1) == 8);
}

TEST_CASE("what is wrong with all images is said in words once they are missed") {
    CameraRos2Harness h;
    REQUIRE(ok(h.camera.start()));
    for (int i = 0; i < 60 && h.camera.counters().errors == 0; ++i) {
        (void)h.offer_corrupt();
        CameraFrame frame;
        (void)h.camera.next({}, frame);
    }
    CHECK(std::string(h.camera.problem()).find("encoded as 'bayer_rggb16'") != std::string::npos);
    CHECK(h.camera.camera_counters().misfits > 0);
    CHECK(h.camera.counters().corrupt == h.camera.camera_counters().misfits);
}

TEST_CASE("compressed images are decoded, and damaged ones dropped") {
    constexpr int kJpegWidth = 64;
    constexpr int kJpegHeight = 48;
    CameraRos2Options options = tiny_options();
    options.topic = "/left/image_raw/compressed";
    options.width = kJpegWidth;
    options.height = kJpegHeight;
    CameraRos2Harness h(options);
    REQUIRE(ok(h.camera.start()));
    const std::vector<std::uint8_t> jpeg = test::jpeg_of(kJpegWidth, kJpegHeight, test::Jpeg{});
    const auto add = [&](std::vector<std::uint8_t> data) {
        h.clock.advance(kPeriod);
        h.add("rgb8; jpeg compressed bgr8", std::move(data), h.clock.read_pair().realtime);
        h.node.graph.images.back().image.is_compressed = true;
    };
    add(jpeg);
    CameraFrame frame;
    REQUIRE(ok(h.camera.next({}, frame)));
    CHECK(std::abs(int{frame.image.at(20, 20)} - test::luma_at(20, 20)) < 8);
    add({jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(jpeg.size() / 2)});
    CHECK(h.camera.next({}, frame) == Status::kCorrupt);
    CHECK(h.camera.camera_counters().damaged == 1);
    CHECK(std::string(h.camera.problem()).find("no JPEGs of 64x48") != std::string::npos);
}

TEST_CASE("camera_info that contradicts the calibration is warned of") {
    CameraRos2Options options = tiny_options();
    options.model = {4, 2, 3.0, 3.0, 1.5, 0.5};
    const auto warning_of = [&](const Ros2CameraModel& info) {
        CameraRos2Harness h(options);
        CHECK(h.node.info_topic == "/left/camera_info");
        CHECK(h.node.is_rectified);
        REQUIRE(ok(h.camera.start()));
        h.node.graph.models.push_back(info);
        h.offer(1);
        CHECK(test::drain(static_cast<test::CameraHarness&>(h)).stamps.size() == 1);
        return std::string(h.camera.warning());
    };
    CHECK(warning_of(options.model).empty());
    CHECK(warning_of({4, 2, 3.05, 2.95, 1.52, 0.5}).empty());
    CHECK(warning_of({4, 2, 3.2, 3.0, 1.5, 0.5}).find("fx 3.2") != std::string::npos);
    CHECK(warning_of({8, 4, 6.0, 6.0, 3.5, 1.5}).find("8x4") != std::string::npos);
    CHECK_FALSE(warning_of({4, 2, std::nan(""), 3.0, 1.5, 0.5}).empty());
}

TEST_CASE("messages that the middleware lost are counted, also across an outage") {
    CameraRos2Harness h;
    REQUIRE(ok(h.camera.start()));
    h.node.graph.lost = 3;
    CHECK(h.camera.counters().lost == 3);
    h.camera.stop();
    CHECK(h.camera.counters().lost == 3);
    REQUIRE(ok(h.camera.start()));
    h.node.graph.lost = 1;
    CHECK(h.camera.counters().lost == 4);
}

}  // namespace
}  // namespace facet::camera_ros2_test
