// SPDX-License-Identifier: BSD-2-Clause
// The formats of cameras on USB: which one is taken, at which rate, and what becomes of damaged images.
#include <catch2/catch.hpp>

#include "drivers/camera_v4l2/camera_v4l2.h"
#include "tests/drivers/camera_v4l2/camera_harness.h"
#include "tests/support/jpeg_images.h"

namespace facet::camera_formats_test {
namespace {

CameraV4l2Options any_format(double rate_hz) {
    CameraV4l2Options options = judged_options();
    options.capture.any_format = true;
    options.capture.rate_hz = rate_hz;
    return options;
}

TEST_CASE("of what a camera has, the first format is taken that has the size and reaches the rate") {
    const auto taken = [](std::vector<test::FakeCamera::Mode> modes, double rate_hz, bool two_views = false) {
        CameraV4l2Options options = any_format(rate_hz);
        options.capture.has_two_views = two_views;
        CameraV4l2Harness h(false, options);
        h.kernel.modes = std::move(modes);
        CAPTURE(h.camera.problem());
        CHECK(h.camera.start() == Status::kOk);
        return h.kernel.format;
    };
    const test::FakeCamera::Mode jpeg{V4L2_PIX_FMT_MJPEG, 8, 0, 60.0};
    const test::FakeCamera::Mode slow{V4L2_PIX_FMT_YUYV, 8, 16, 10.0};
    const test::FakeCamera::Mode other_size{V4L2_PIX_FMT_GREY, 16, 16, 60.0};
    const test::FakeCamera::Mode both{V4L2_PIX_FMT_Y8I, 4, 8, 60.0};
    CHECK(taken({other_size, slow, jpeg}, 10.0) == V4L2_PIX_FMT_YUYV);
    CHECK(taken({other_size, slow, jpeg}, 30.0) == V4L2_PIX_FMT_MJPEG);
    CHECK(taken({other_size, slow}, 30.0) == V4L2_PIX_FMT_YUYV);  // rather than none
    CHECK(taken({jpeg, both}, 30.0, true) == V4L2_PIX_FMT_Y8I);
    CHECK(taken({jpeg, both}, 30.0, false) == V4L2_PIX_FMT_MJPEG);
    CHECK(taken({jpeg, {V4L2_PIX_FMT_NV12, 8, 8, 60.0}, slow}, 30.0) == V4L2_PIX_FMT_NV12);
}

TEST_CASE("a node without any of the formats says what it gives") {
    CameraV4l2Harness h(false, any_format(30.0));
    h.kernel.modes = {{V4L2_PIX_FMT_H264, 8, 8, 60.0}};
    CHECK(h.camera.start() == Status::kInvalidArgument);
    CHECK(h.camera.problem() == "/dev/video0: gives 8x4 H264 instead of the size and format requested");
}

TEST_CASE("a camera that nobody triggers is set to its rate, and another rate is reported") {
    CameraV4l2Harness h(false, any_format(30.0));
    REQUIRE(ok(h.camera.start()));
    CHECK(h.kernel.rate_hz == Approx(30.0));
    CHECK(h.camera.warning().empty());
    CameraV4l2Harness slow(false, any_format(30.0));
    slow.kernel.most_hz = 15.0;
    REQUIRE(ok(slow.camera.start()));
    CHECK(slow.camera.warning() == "/dev/video0: takes 15 frames a second instead of cameras.rate_hz");
    CameraV4l2Harness fixed(false, any_format(30.0));
    fixed.kernel.has_rate = false;
    REQUIRE(ok(fixed.camera.start()));
    CHECK(fixed.camera.warning().empty());
    CameraV4l2Harness triggered;
    REQUIRE(ok(triggered.camera.start()));
    CHECK(triggered.kernel.rate_hz == 0.0);
}

TEST_CASE("both views of an interleaved image come out side by side") {
    CameraV4l2Options options = any_format(0.0);
    options.capture.format = PixelFormat::kY8i;
    options.capture.any_format = false;
    options.capture.has_two_views = true;
    CameraV4l2Harness h(false, options);
    h.kernel.modes = {{V4L2_PIX_FMT_Y8I, 4, 8, 60.0}};
    REQUIRE(ok(h.camera.start()));
    std::vector<std::uint8_t> bytes(32);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] = static_cast<std::uint8_t>(i % 2 == 0 ? i / 2 : 100 + i / 2);
    }
    h.kernel.expose_bytes(bytes, 2'000'000'000);
    CameraFrame frame;
    REQUIRE(h.camera.next({}, frame) == Status::kOk);
    CHECK(frame.image.width == 8);
    CHECK(frame.image.height == 4);
    CHECK(frame.image.row(0)[3] == 3);
    CHECK(frame.image.row(0)[4] == 100);
    CHECK(frame.image.row(3)[0] == 12);
    CHECK(frame.image.row(3)[7] == 115);
}

TEST_CASE("a damaged JPEG is one bad frame, and a camera that sends no others is reopened") {
    constexpr int kWidth = 64;
    constexpr int kHeight = 32;
    CameraV4l2Options options = any_format(0.0);
    options.capture.width = kWidth;
    options.capture.height = kHeight;
    CameraV4l2Harness h(false, options);
    h.kernel.width = kWidth;
    h.kernel.height = kHeight;
    h.kernel.modes = {{V4L2_PIX_FMT_MJPEG, kWidth, 4 * kWidth, 60.0}};
    REQUIRE(ok(h.camera.start()));
    const std::vector<std::uint8_t> good = test::jpeg_of(kWidth, kHeight, {.h = 2, .has_tables = false});
    std::vector<std::uint8_t> cut = good;
    cut.resize(good.size() * 2 / 3);
    int frames = 0;
    const auto show = [&](const std::vector<std::uint8_t>& bytes) {
        h.clock.advance(Duration::from_seconds(0.05));
        h.kernel.expose_bytes(bytes, h.clock.now().ns);
        CameraFrame frame;
        const Status status = h.camera.next({}, frame);
        (void)h.camera.next({}, frame);  // "none ready" after each frame
        if (ok(status)) {
            ++frames;
            CHECK(std::abs(frame.image.row(8)[8] - test::luma_at(8, 8)) < 12);
        }
        return status;
    };
    CHECK(show(good) == Status::kOk);
    CHECK(show(cut) == Status::kCorrupt);
    CHECK(show({1, 2, 3, 4, 5}) == Status::kCorrupt);
    CHECK(show(good) == Status::kOk);
    CHECK(h.camera.counters().corrupt == 2);
    CHECK(h.camera.camera_counters().damaged == 2);
    CHECK(h.camera.counters().errors == 0);
    CHECK(frames == 2);
    Status status = Status::kCorrupt;
    for (int i = 0; i < 100 && h.camera.counters().errors == 0; ++i) {
        status = show(cut);
    }
    CAPTURE(status);
    CHECK(h.camera.counters().errors == 1);
    CHECK_THAT(std::string(h.camera.problem()), Catch::Contains("every JPEG is damaged"));
}

}  // namespace
}  // namespace facet::camera_formats_test
