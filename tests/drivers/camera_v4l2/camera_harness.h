// SPDX-License-Identifier: BSD-2-Clause
// A small camera on a scripted kernel.
#pragma once

#include "drivers/camera_v4l2/camera_v4l2.h"
#include "tests/drivers/camera_v4l2/fake_camera.h"
#include "tests/port_conformance/source_conformance.h"

namespace facet {

inline CameraV4l2Options small_options() {
    CameraV4l2Options options;
    options.capture.width = 8;
    options.capture.height = 4;
    return options;
}

inline CameraV4l2Options judged_options() {
    CameraV4l2Options options = small_options();
    options.silence = Duration::from_seconds(1.0);
    return options;
}

class CameraV4l2Harness final : public test::CameraHarness {
public:
    explicit CameraV4l2Harness(bool multiplanar = false, const CameraV4l2Options& options = small_options())
        : camera(kernel, clock, options) {
        kernel.multiplanar = multiplanar;
        kernel.plane_offset = multiplanar ? 64 : 0;
    }
    CameraSource& source() override { return camera; }
    // More frames than buffers: the suite asks for ten at once, so that they are taken as they come.
    void offer(int count) override { waiting += count; }
    test::Hook offer_corrupt() override { return test::Hook::kCannot; }  // PumpedHarness's are the hooks
    test::Hook offer_ahead() override { return test::Hook::kCannot; }
    test::Hook break_device() override {
        kernel.present = false;
        return test::Hook::kDone;
    }
    void repair_device() override { kernel.present = true; }
    test::Hook judges_silence() override { return test::Hook::kCannot; }
    test::Hook end() override { return test::Hook::kCannot; }
    void pass_time() override {
        clock.advance(Duration::from_seconds(0.6));
        stamp_ns = clock.now().ns;
    }
    int held_back() const override { return 0; }
    void expose_one() {
        if (waiting > 0) {
            --waiting;
            stamp_ns += 50'000'000;
            kernel.expose(static_cast<std::uint8_t>(stamp_ns / 50'000'000), stamp_ns);
        }
    }

    ManualClock clock{{1'000'000'000}};
    test::FakeCamera kernel{clock};
    CameraV4l2 camera;
    int waiting = 0;
    std::int64_t stamp_ns = 2'000'000'000;
};

/// A camera at 20 Hz for a while, asked after each frame. @return frames delivered
inline int run_camera(CameraV4l2Harness& h, double seconds, std::uint32_t flags = 0, std::uint32_t cut = 0) {
    int frames = 0;
    for (int i = 0; i < static_cast<int>(seconds * 20.0 + 0.5); ++i) {
        h.clock.advance(Duration::from_seconds(0.05));
        h.kernel.expose(1, h.clock.now().ns, flags, cut);
        CameraFrame frame;
        frames += ok(h.camera.next({}, frame)) ? 1 : 0;
        (void)h.camera.next({}, frame);  // "none ready" after each frame
    }
    return frames;
}

}  // namespace facet
