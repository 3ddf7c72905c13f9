// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/auto_exposure.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "drivers/camera_v4l2/camera_v4l2.h"
#include "tests/drivers/camera_v4l2/fake_camera.h"

namespace facet::auto_exposure_test {
namespace {

AutoExposureOptions options() {
    AutoExposureOptions o;
    o.exposure_control = "exposure_time_absolute";
    o.exposure_step_s = 1e-4;
    o.gain_one = o.least_gain = 16;
    o.most_gain = 256;
    o.least_exposure = 2;
    o.most_exposure = 100;
    return o;
}

/// An image whose pixels have grey values in equal parts.
struct Picture {
    explicit Picture(const std::vector<double>& greys) : pixels(kSide * kSide) {
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const std::size_t part = i % kSide * greys.size() / kSide;  // by column
            pixels[i] = static_cast<std::uint8_t>(std::clamp(greys[part], 0.0, 255.0));
        }
    }
    ImageView view() const { return {pixels.data(), kSide, kSide, kSide}; }
    static constexpr int kSide = 80;
    std::vector<std::uint8_t> pixels;
};

/// What a camera sees of a scene at a setting: radiances times light taken in.
Picture seen_at(const ExposureSetting& setting, std::vector<double> radiances) {
    for (double& value : radiances) {
        value *= setting.exposure * setting.gain / 16.0;
    }
    return Picture(radiances);
}

TEST_CASE("brightness is that of the pixels") {
    const Brightness b = measure_brightness(Picture({10, 20, 30, 40, 255}).view());
    CHECK(b.median == 30.0);
    CHECK(b.bright == 255.0);
    CHECK(b.saturated == Approx(0.2));
}

/// Runs a rig of two cameras in a scene whose light may change; frames show a setting two frames after it is made.
struct Rig {
    explicit Rig(const AutoExposureOptions& o) : exposure(o) {
        for (auto& s : waiting) {
            s = exposure.setting();
        }
    }
    /// @return the median of the last image of a camera that lives: the left one if both do
    double run(int frames, double light, double right_is_brighter = 1.0) {
        double median = 0.0;
        for (int i = 0; i < frames; ++i) {
            const ExposureSetting in_force = waiting[0];
            waiting[0] = waiting[1];
            const std::vector<double> scene{0.2 * light, 0.5 * light, light, 1.5 * light, 2.0 * light};
            std::vector<double> right = scene;
            for (double& value : right) {
                value *= right_is_brighter;
            }
            if (right_lives) {
                const Picture image = seen_at(in_force, right);
                median = measure_brightness(image.view()).median;
                exposure.add_image(1, image.view());
            }
            if (left_lives) {
                const Picture image = seen_at(in_force, scene);
                median = measure_brightness(image.view()).median;
                exposure.add_image(0, image.view());
            }
            changes += exposure.setting() == waiting[1] ? 0 : 1;
            waiting[1] = exposure.setting();
        }
        return median;
    }
    SharedExposure exposure;
    std::array<ExposureSetting, 2> waiting;
    bool left_lives = true;
    bool right_lives = true;
    int changes = 0;
};

TEST_CASE("the median comes to its target within a second, and rests there") {
    for (const double light : {1.5, 8.0, 40.0}) {
        INFO(light);
        Rig rig(options());
        CHECK(std::abs(rig.run(30, light) / 90.0 - 1.0) < 0.12);
        const int before = rig.changes;
        (void)rig.run(100, light);
        CHECK(rig.changes == before);
    }
}

TEST_CASE("exposure goes first, gain only when exposure is at its bound, and both stay within theirs") {
    Rig dim(options());
    (void)dim.run(60, 0.3);
    CHECK(dim.exposure.setting().exposure == 100);
    CHECK(dim.exposure.setting().gain > 16);
    CHECK(dim.exposure.setting().gain < 256);
    Rig dark(options());
    (void)dark.run(60, 0.001);
    CHECK(dark.exposure.setting() == ExposureSetting{100, 256});
    Rig bright(options());
    (void)bright.run(60, 1000.0);
    CHECK(bright.exposure.setting() == ExposureSetting{2, 16});
    Rig day(options());
    (void)day.run(60, 10.0);
    CHECK(day.exposure.setting().gain == 16);
}

TEST_CASE("out of a tunnel into the light and back, without swinging") {
    Rig rig(options());
    (void)rig.run(60, 1.0);
    const int before = rig.changes;
    CHECK(std::abs(rig.run(40, 30.0) / 90.0 - 1.0) < 0.12);
    CHECK(rig.changes - before <= 10);
    CHECK(std::abs(rig.run(40, 1.0) / 90.0 - 1.0) < 0.12);
}

TEST_CASE("the brighter camera is not blinded") {
    Rig rig(options());
    (void)rig.run(60, 5.0, 1.4);
    const ExposureSetting s = rig.exposure.setting();
    CHECK(2.0 * 5.0 * 1.4 * s.exposure * s.gain / 16.0 < 256.0);
}

TEST_CASE("a camera that has died does not decide what the living one sees") {
    for (const bool left_dies : {false, true}) {
        for (const double later : {0.1, 1.0, 8.0}) {
            CAPTURE(left_dies, later);
            // GIVEN a rig whose one camera has a few pixels too bright when it dies
            Rig rig(options());
            (void)rig.run(60, 4.0);
            (left_dies ? rig.left_lives : rig.right_lives) = false;
            const Picture glare(std::vector<double>(16, 100.0));
            Picture last = glare;
            std::fill_n(last.pixels.begin(), last.pixels.size() * 6 / 100, std::uint8_t{255});
            rig.exposure.add_image(left_dies ? 0 : 1, last.view());
            // WHEN the light changes THEN the living one has its image right again within two seconds
            CHECK(std::abs(rig.run(40, 4.0 * later) / 90.0 - 1.0) < 0.12);
            // AND both follow when the other comes back
            rig.left_lives = rig.right_lives = true;
            CHECK(std::abs(rig.run(40, 4.0, 1.2) / 90.0 - 1.0) < 0.25);
        }
    }
}

TEST_CASE("a rig that never had but one of its cameras is exposed by that one") {
    Rig rig(options());
    rig.left_lives = false;
    CHECK(std::abs(rig.run(60, 10.0) / 90.0 - 1.0) < 0.12);
}

TEST_CASE("half an hour of changing light with either camera dead: the living one always sees") {
    Rig rig(options());
    int bad = 0;
    constexpr int kStep = 20;  // images, a second
    for (int second = 0; second < 1800; ++second) {
        rig.left_lives = second / 300 % 2 == 0;  // every five minutes the other one
        rig.right_lives = !rig.left_lives;
        const double light = 4.0 * std::exp(2.0 * std::sin(second / 20.0));
        const double median = rig.run(kStep, light);
        bad += second % 300 > 1 && std::abs(std::log(median / 90.0)) > 0.35 ? 1 : 0;
    }
    CHECK(bad == 0);
}

TEST_CASE("a frame has the exposure that was in force") {
    ExposureHistory history;
    CHECK(history.at(5, Duration{7}) == Duration{7});
    history.add(0, Duration{100});
    history.add(10, Duration{200});
    CHECK(history.at(9, {}) == Duration{100});
    CHECK(history.at(10, {}) == Duration{200});
    for (std::uint32_t i = 0; i < 20; ++i) {
        history.add(100 + i, Duration{300 + static_cast<std::int64_t>(i)});
    }
    CHECK(history.at(119, {}) == Duration{319});
    CHECK(history.at(5, {}) == Duration{312});  // longer ago than is kept
    history.clear();
    CHECK(history.at(5, Duration{7}) == Duration{7});
}

TEST_CASE("a camera sets what the rig decides, and stamps the middle of each frame's own exposure") {
    ManualClock clock({1'000'000'000});
    test::FakeCamera kernel(clock);
    CameraV4l2Options camera_options;
    camera_options.capture.width = 8;
    camera_options.capture.height = 4;
    camera_options.stamp_source = StampSource::kStartOfExposure;
    AutoExposureOptions o = options();
    o.least_exposure = 10;
    SharedExposure shared(o);
    CameraV4l2 camera(kernel, clock, camera_options, &shared);
    REQUIRE(ok(camera.start()));
    const ExposureSetting first = shared.setting();
    CHECK(first.exposure == 32);  // the middle, by ratio
    CHECK(kernel.exposure == 32);
    CHECK(kernel.set_while_streaming == 0);
    std::vector<Duration> exposures;
    for (int i = 0; i < 4; ++i) {
        const std::int64_t stamp_ns = 2'000'000'000 + i * 50'000'000LL;
        kernel.expose(40, stamp_ns);
        CameraFrame frame;
        REQUIRE(ok(camera.next({}, frame)));
        exposures.push_back(frame.exposure);
        CHECK(frame.stamp.ns == stamp_ns + frame.exposure.ns / 2);
        CameraFrame none;
        (void)camera.next({}, none);
    }
    // Too dark: twice as long is asked for at once, and is there two frames later.
    CHECK(kernel.exposure == 64);
    CHECK(camera.camera_counters().exposures_set == 1);
    CHECK(kernel.set_while_streaming == 2);  // two system calls a step, and none to look the controls up
    CHECK(kernel.asked_while_streaming == 0);
    CHECK(exposures == std::vector<Duration>{{3'200'000}, {3'200'000}, {6'400'000}, {6'400'000}});
}

}  // namespace
}  // namespace facet::auto_exposure_test
