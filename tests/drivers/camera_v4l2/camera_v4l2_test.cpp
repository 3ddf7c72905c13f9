// SPDX-License-Identifier: BSD-2-Clause
#include <catch2/catch.hpp>

#include "drivers/camera_v4l2/camera_v4l2.h"
#include "tests/drivers/camera_v4l2/camera_harness.h"

namespace facet::camera_v4l2_test {
namespace {

/// Exposes what was offered, a few at a time, whenever the camera is asked.
class PumpedHarness final : public test::CameraHarness {
public:
    explicit PumpedHarness(bool multiplanar) : inner_(multiplanar, judged_options()), pump_(inner_) {}
    CameraSource& source() override { return pump_; }
    void offer(int count) override { inner_.offer(count); }
    test::Hook offer_corrupt() override {
        pump_.corrupt = true;
        return test::Hook::kDone;
    }
    test::Hook offer_ahead() override {
        pump_.ahead = true;
        return test::Hook::kDone;
    }
    test::Hook break_device() override { return inner_.break_device(); }
    test::Hook judges_silence() override { return test::Hook::kDone; }
    test::Hook end() override { return test::Hook::kCannot; }
    int held_back() const override { return 0; }
    void repair_device() override { inner_.repair_device(); }
    void pass_time() override { inner_.pass_time(); }

private:
    /// Lets one frame through before each question.
    class Pump final : public CameraSource {
    public:
        explicit Pump(CameraV4l2Harness& h) : h_(h) {}
        bool corrupt = false;
        bool ahead = false;
        Status start() override { return h_.camera.start(); }
        void stop() override { h_.camera.stop(); }
        ClockDomain clock() const override { return h_.camera.clock(); }
        SourceCounters counters() const override { return h_.camera.counters(); }
        std::string_view problem() const override { return h_.camera.problem(); }
        Status next(Duration timeout, CameraFrame& frame) override {
            if (corrupt || ahead) {
                h_.kernel.stamp_error_ns = ahead ? 3'600'000'000'000 : 0;
                h_.stamp_ns += 50'000'000;
                h_.kernel.expose(0, h_.stamp_ns, corrupt ? V4L2_BUF_FLAG_ERROR : 0);
                h_.kernel.stamp_error_ns = 0;
                corrupt = ahead = false;
            } else if (h_.kernel.streaming) {
                h_.expose_one();
            }
            return h_.camera.next(timeout, frame);
        }

    private:
        CameraV4l2Harness& h_;
    };
    CameraV4l2Harness inner_;
    Pump pump_;
};

TEST_CASE("the V4L2 camera keeps the contract of its port, single- and multi-planar", "[port_conformance]") {
    for (const bool multiplanar : {false, true}) {
        test::check_source_conformance<test::CameraHarness>(
            [=] { return std::make_unique<PumpedHarness>(multiplanar); });
    }
}

TEST_CASE("pixels come through, also from behind a plane's data offset") {
    for (const bool multiplanar : {false, true}) {
        CameraV4l2Harness h(multiplanar);
        REQUIRE(ok(h.camera.start()));
        h.kernel.expose(123, 2'000'000'000);
        CameraFrame frame;
        REQUIRE(h.camera.next({}, frame) == Status::kOk);
        CHECK(frame.image.width == 8);
        CHECK(frame.image.height == 4);
        CHECK(frame.image.at(7, 3) == 123);
        CHECK(h.kernel.mapped == 4);
        h.camera.stop();
        CHECK(h.kernel.mapped == 0);
    }
}

TEST_CASE("the newest frame is given, older ones are counted, and the driver never starves") {
    CameraV4l2Harness h;
    h.kernel.one_by_one = false;
    REQUIRE(ok(h.camera.start()));
    for (int round = 0; round < 50; ++round) {
        for (std::uint8_t i = 0; i < 3; ++i) {
            h.stamp_ns += 1'000'000;
            h.kernel.expose(i, h.stamp_ns);
        }
        CameraFrame frame;
        REQUIRE(h.camera.next({}, frame) == Status::kOk);
        CHECK(frame.image.at(0, 0) == 2);
        CHECK(frame.stamp.ns == h.stamp_ns);
    }
    CHECK(h.kernel.starved == 0);
    CHECK(h.camera.camera_counters().superseded == 100);
    CHECK(h.camera.counters().discarded == 100);
    CHECK(h.camera.counters().lost == 0);
}

TEST_CASE("a consumer that holds every slot loses frames, not the camera") {
    CameraV4l2Harness h;
    REQUIRE(ok(h.camera.start()));
    std::vector<CameraFrame> held;
    for (int i = 0; i < 10; ++i) {
        h.stamp_ns += 1'000'000;
        h.kernel.expose(static_cast<std::uint8_t>(i), h.stamp_ns);
        CameraFrame frame;
        if (ok(h.camera.next({}, frame))) {
            held.push_back(std::move(frame));
        }
        CameraFrame none;
        (void)h.camera.next({}, none);
    }
    REQUIRE(held.size() == CameraV4l2::kSlots);
    for (std::size_t i = 0; i < held.size(); ++i) {
        CHECK(held[i].image.at(3, 2) == i);  // nothing was written over
    }
    CHECK(h.camera.camera_counters().no_slot == 10 - CameraV4l2::kSlots);
    CHECK(h.kernel.starved == 0);
    const int freed = held[1].slot.slot();
    held.erase(held.begin() + 1);
    h.kernel.expose(99, h.stamp_ns + 1'000'000);
    CameraFrame frame;
    REQUIRE(h.camera.next({}, frame) == Status::kOk);
    CHECK(frame.slot.slot() == freed);
}

TEST_CASE("stamps become exposure midpoints") {
    CameraV4l2Options options = small_options();
    options.exposure = {4'000'000};
    options.readout = {10'000'000};
    const auto stamp = [&](StampSource source, std::uint32_t flags) {
        options.stamp_source = source;
        CameraV4l2Harness h(false, options);
        REQUIRE(ok(h.camera.start()));
        h.kernel.expose(1, 2'000'000'000, flags);
        CameraFrame frame;
        REQUIRE(h.camera.next({}, frame) == Status::kOk);
        CHECK(frame.exposure.ns == 4'000'000);
        return frame.stamp.ns - 2'000'000'000;
    };
    CHECK(stamp(StampSource::kAsFlagged, 0) == -12'000'000);
    CHECK(stamp(StampSource::kAsFlagged, V4L2_BUF_FLAG_TSTAMP_SRC_SOE) == 2'000'000);
    CHECK(stamp(StampSource::kStartOfExposure, 0) == 2'000'000);
    CHECK(stamp(StampSource::kEndOfFrame, V4L2_BUF_FLAG_TSTAMP_SRC_SOE) == -12'000'000);
    CHECK(stamp(StampSource::kMidExposure, 0) == 0);
}

TEST_CASE("sequence gaps, error flags and short buffers are counted") {
    CameraV4l2Harness h;
    REQUIRE(ok(h.camera.start()));
    CameraFrame frame;
    const auto next = [&] {
        const Status status = h.camera.next({}, frame);
        CameraFrame none;
        (void)h.camera.next({}, none);
        return status;
    };
    h.kernel.expose(1, 2'000'000'000);
    CHECK(next() == Status::kOk);
    h.kernel.next_sequence += 3;
    h.kernel.expose(1, 2'100'000'000);
    CHECK(next() == Status::kOk);
    CHECK(h.camera.counters().lost == 3);
    h.kernel.expose(1, 2'200'000'000, V4L2_BUF_FLAG_ERROR);
    CHECK(next() == Status::kCorrupt);
    h.kernel.expose(1, 2'300'000'000, 0, 1);
    CHECK(next() == Status::kCorrupt);
    CHECK(h.camera.camera_counters().error_buffers == 1);
    CHECK(h.camera.camera_counters().short_buffers == 1);
    CHECK(h.camera.counters().corrupt == 2);
    h.kernel.flags = 0;
    h.kernel.expose(1, 2'400'000'000);
    CHECK(next() == Status::kOk);
    CHECK(h.camera.camera_counters().not_monotonic == 1);
    h.kernel.expose(1, 2'400'000'000);  // the same stamp again
    CHECK(next() == Status::kNotReady);
    CHECK(h.camera.counters().lost == 3);
}

TEST_CASE("controls are set by name, also after the node came back") {
    CameraV4l2Options options = small_options();
    options.controls = {{"exposure_time_absolute", 55}, {"analogue_gain", 2}};
    CameraV4l2Harness h(false, options);
    REQUIRE(ok(h.camera.start()));
    CHECK(h.kernel.exposure == 55);
    h.kernel.exposure = 100;
    h.kernel.present = false;
    CameraFrame frame;
    CHECK(h.camera.next({}, frame) == Status::kIo);
    CHECK(h.camera.problem() == "/dev/video0: delivers no frames: No such device");
    CHECK(h.camera.next({}, frame) == Status::kNotReady);
    h.kernel.present = true;
    h.pass_time();
    CHECK(h.camera.next({}, frame) == Status::kNotReady);
    CHECK(h.kernel.exposure == 55);
    CHECK(h.kernel.streaming);

    options.controls = {{"exposure_time_absolute", 5000}};
    CameraV4l2Harness beyond(false, options);
    CHECK(beyond.camera.start() == Status::kInvalidArgument);
    CHECK(beyond.camera.problem() == "/dev/video0: control exposure_time_absolute must be 1 to 1000, not 5000");
    options.controls = {{"shutter", 1}};
    CameraV4l2Harness unknown(false, options);
    CHECK(unknown.camera.start() == Status::kOk);
    CHECK(unknown.kernel.streaming);
    CHECK(unknown.camera.warning() ==
          "/dev/video0: has no control shutter; there are: analogue_gain, exposure_time_absolute");
}

TEST_CASE("controls are set before the first image, on the sensor's own node if it has one") {
    CameraV4l2Options options = small_options();
    options.controls = {{"exposure_time_absolute", 55}, {"analogue_gain", 2}};
    CameraV4l2Harness h(false, options);
    REQUIRE(ok(h.camera.start()));
    CHECK(h.kernel.set_while_streaming == 0);
    CHECK(h.kernel.asked_for_cached);
    CHECK(h.camera.warning().empty());
    // Exposure and gain of a bridge's capture node are on the sensor's subdevice.
    CameraV4l2Harness elsewhere(false, options);
    elsewhere.kernel.controls_at = "/dev/v4l-subdev2";
    CHECK(elsewhere.camera.start() == Status::kOk);
    CHECK(elsewhere.camera.warning() ==
          "/dev/video0: has no control exposure_time_absolute; there are none; /dev/video0: has no control "
          "analogue_gain; there are none");
    CHECK(elsewhere.kernel.exposure == 100);
    options.controls_device = "/dev/v4l-subdev2";
    CameraV4l2Harness subdevice(false, options);
    subdevice.kernel.controls_at = "/dev/v4l-subdev2";
    REQUIRE(ok(subdevice.camera.start()));
    CHECK(subdevice.camera.warning().empty());
    CHECK(subdevice.kernel.exposure == 55);
    CHECK(subdevice.kernel.set_while_streaming == 0);
    CHECK(subdevice.kernel.controls_open == 1);
    subdevice.camera.stop();
    CHECK(subdevice.kernel.controls_open == 0);
    options.controls_device = "/dev/v4l-subdev7";
    CameraV4l2Harness missing(false, options);
    CHECK(missing.camera.start() == Status::kNotFound);
    CHECK(missing.camera.problem() == "/dev/v4l-subdev7: cannot be opened: No such file or directory");
    CHECK_FALSE(missing.kernel.streaming);
}

TEST_CASE("a node that cannot do what is asked says what it can") {
    CameraV4l2Harness h;
    h.kernel.format = V4L2_PIX_FMT_YUYV;
    CHECK(h.camera.start() == Status::kInvalidArgument);
    CHECK(h.camera.problem() == "/dev/video0: gives 8x4 YUYV instead of the size and format requested");
    CHECK_FALSE(h.kernel.streaming);
    CameraV4l2Harness missing;
    missing.kernel.present = false;
    CHECK(missing.camera.start() == Status::kNotFound);
    CHECK(missing.camera.problem() == "/dev/video0: cannot be opened: No such file or directory");
    CameraV4l2Options options;
    CameraV4l2Harness unsized(false, options);
    CHECK(unsized.camera.start() == Status::kInvalidArgument);
    CameraV4l2Harness few;
    few.kernel.max_buffers = 1;
    CHECK(few.camera.start() == Status::kIo);
}

TEST_CASE("buffers of a DMA heap are lent to the driver, read in brackets and given back") {
    for (const bool multiplanar : {false, true}) {
        CameraV4l2Options options = small_options();
        options.capture.heap = "/dev/dma_heap/system";
        CameraV4l2Harness h(multiplanar, options);
        h.kernel.one_by_one = false;
        REQUIRE(ok(h.camera.start()));
        CHECK(h.kernel.dmabufs_open == 4);
        CHECK(h.kernel.mapped == 4);
        CameraFrame frame;
        for (std::uint8_t round = 1; round < 20; ++round) {  // two at a time: the older one is not looked at
            h.kernel.expose(0, round * 100'000'000 - 50'000'000);
            h.kernel.expose(round, round * 100'000'000);
            REQUIRE(h.camera.next({}, frame) == Status::kOk);
            CHECK(frame.image.at(7, 3) == round);
        }
        CHECK(h.kernel.synchronised == 19 * 4);
        CHECK(h.kernel.starved == 0);
        h.kernel.present = false;
        CHECK(h.camera.next({}, frame) == Status::kIo);
        CHECK(h.kernel.dmabufs_open == 0);
        h.kernel.present = true;
        h.pass_time();
        CHECK(h.camera.next({}, frame) == Status::kNotReady);
        CHECK(h.kernel.dmabufs_open == 4);
        h.camera.stop();
        CHECK(h.kernel.dmabufs_open == 0);
        CHECK(h.kernel.mapped == 0);
    }
}

/// Each look at it takes a while, as copying does.
class SlowClock final : public Clock {
public:
    explicit SlowClock(Duration look) : look_(look) {}
    Timestamp now() const override {
        now_ = now_ + look_;
        return now_;
    }
    ClockPair read_pair() const override { return {}; }
    void sleep_until(Timestamp) override {}

private:
    Duration look_;
    mutable Timestamp now_;
};

TEST_CASE("buffers that are slow to read are reported once they have been read for a while") {
    const auto warning = [](Duration copy) {
        SlowClock clock(copy);
        ManualClock manual;
        test::FakeCamera kernel(manual);
        kernel.width = kernel.stride = 640;
        kernel.height = 480;
        CameraV4l2Options options = small_options();
        options.capture.width = 640;
        options.capture.height = 480;
        CameraV4l2 camera(kernel, clock, options);
        REQUIRE(ok(camera.start()));
        CameraFrame frame;
        for (std::int64_t i = 0; i < 50; ++i) {
            kernel.expose(static_cast<std::uint8_t>(i), clock.now().ns);
            (void)camera.next({}, frame);
            frame = {};
        }
        CHECK(camera.counters().delivered == 50);
        return std::string(camera.warning());
    };
    CHECK(warning({1'000'000}).empty());  // 307 kB in 1 ms
    CHECK(warning({1'100'000}) ==
          "/dev/video0: an image takes 1100 us to copy out of its buffer, which is not cached: set cameras.heap");
}

TEST_CASE("a heap that is not there, is exhausted or is not accepted is named, and nothing is left of it") {
    CameraV4l2Options options = small_options();
    options.capture.heap = "/dev/dma_heap/nowhere";
    CameraV4l2Harness missing(false, options);
    CHECK(missing.camera.start() == Status::kNotFound);
    CHECK(missing.camera.problem() == "/dev/video0: /dev/dma_heap/nowhere cannot be opened: No such file or directory");
    options.capture.heap = "/dev/dma_heap/system";
    CameraV4l2Harness full(false, options);
    full.kernel.heap_room = 2;
    CHECK(full.camera.start() == Status::kIo);
    CHECK(full.camera.problem() == "/dev/video0: the heap gives no memory: Cannot allocate memory");
    CHECK(full.kernel.dmabufs_open == 0);
    CHECK(full.kernel.mapped == 0);
    CameraV4l2Harness refused(false, options);
    refused.kernel.takes_dmabuf = false;
    CHECK(refused.camera.start() == Status::kIo);
    CHECK(refused.camera.problem() == "/dev/video0: takes no buffers of a heap: Invalid argument");
}

TEST_CASE("waiting for a buffer lasts as long as asked") {
    ManualClock clock;
    test::FakeCamera kernel(clock);
    V4l2Capture capture(kernel);
    std::string problem;
    REQUIRE(ok(capture.prepare({"/dev/video0", 8, 4, PixelFormat::kGrey, 4, ""}, problem)));
    REQUIRE(ok(capture.start(problem)));
    V4l2Buffer buffer;
    CHECK(capture.dequeue({3'000'000}, buffer, problem) == Status::kNotReady);
    CHECK(clock.now().ns == 3'000'000);
}

}  // namespace
}  // namespace facet::camera_v4l2_test
