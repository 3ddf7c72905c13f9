// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/frame_faults.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "app/lab/sim/default_rig.h"

namespace facet::frame_faults_test {
namespace {

constexpr std::int64_t kBegin = 1'000'000'000'000;
constexpr std::int64_t kStep = 50'000'000;  // 20 Hz
constexpr int kWidth = 16;
constexpr int kHeight = 8;

std::uint8_t pixel_of(int frame, int camera) { return static_cast<std::uint8_t>(20 + frame + 100 * camera); }

GreyImage plain(std::uint8_t value) {
    return {.width = kWidth, .height = kHeight, .pixels = std::vector<std::uint8_t>(kWidth * kHeight, value)};
}

/// 80 frames whose images are of one grey each, pixel_of().
std::vector<OwnedFrame> frames(const std::string& spec) {
    FaultSchedule schedule({parse_fault(spec)}, {kBegin});
    FrameFaults faults(schedule, sim::euroc_rig());
    std::vector<OwnedFrame> out;
    for (int i = 0; i < 80; ++i) {
        OwnedFrame frame;
        frame.stamp = frame.log_stamp = frame.output_stamp = {kBegin + i * kStep};
        frame.left = plain(pixel_of(i, 0));
        frame.right = plain(pixel_of(i, 1));
        frame.has_right = true;
        faults.change(frame, static_cast<std::uint64_t>(i) + 1);
        out.push_back(frame);
    }
    return out;
}

double mean(const GreyImage& image) {
    double sum = 0.0;
    for (const std::uint8_t p : image.pixels) {
        sum += p;
    }
    return sum / (kWidth * kHeight);
}

void check_untouched(const std::vector<OwnedFrame>& all, int i) {
    INFO("frame " << i);
    CHECK(mean(all[static_cast<std::size_t>(i)].left) == pixel_of(i, 0));
    CHECK(mean(all[static_cast<std::size_t>(i)].right) == pixel_of(i, 1));
}

TEST_CASE("one camera of two is frozen, black, dark, bright or noisy, and the other is not") {
    for (const bool is_right : {false, true}) {
        const std::string camera = is_right ? "right" : "left";
        const struct {
            std::string spec;
            double low;  // mean of the faulty image at frame 30
            double high;
        } cases[] = {
            {"freeze=" + camera, is_right ? 140.0 : 40.0, is_right ? 140.0 : 40.0},
            {"blackout=" + camera, 1.0, 3.0},
            {"wall=" + camera, 119.0, 121.0},
            {"dark=0.1," + camera, is_right ? 14.0 : 4.0, is_right ? 16.0 : 6.0},
            {"flash=16," + camera, 255.0, 255.0},
            {"smear=" + camera, is_right ? 149.0 : 50.0, is_right ? 151.0 : 100.0},
        };
        for (const auto& c : cases) {
            INFO(c.spec);
            const auto all = frames(c.spec + "@1+1");
            const OwnedFrame& frame = all[30];
            CHECK(mean(is_right ? frame.right : frame.left) >= c.low);
            CHECK(mean(is_right ? frame.right : frame.left) <= c.high);
            CHECK(mean(is_right ? frame.left : frame.right) == pixel_of(30, is_right ? 0 : 1));
            check_untouched(all, 19);
            check_untouched(all, 40);
        }
    }
    const auto noisy = frames("image_noise=10,left@1+1");
    CHECK(noisy[30].left.pixels != plain(pixel_of(30, 0)).pixels);
    CHECK(noisy[30].left.pixels != noisy[31].left.pixels);
    CHECK(mean(noisy[30].left) == Approx(pixel_of(30, 0)).margin(4.0));
    check_untouched(noisy, 40);
}

TEST_CASE("with the exposure stuck images follow the light, up and down") {
    const auto all = frames("exposure=1@1+3");
    CHECK(mean(all[20].left) == pixel_of(20, 0));
    CHECK(mean(all[40].left) == Approx(2.0 * pixel_of(40, 0)));  // 1 s later: a stop brighter
    CHECK(mean(all[40].right) == 255.0);
    CHECK(mean(all[79].left) == Approx(0.5 * pixel_of(79, 0)).epsilon(0.02));  // 2.95 s: a stop darker
    check_untouched(all, 19);
}

TEST_CASE("left and right are exchanged") {
    const auto all = frames("swap@1+1");
    CHECK(mean(all[30].left) == pixel_of(30, 1));
    CHECK(mean(all[30].right) == pixel_of(30, 0));
    check_untouched(all, 40);
}

TEST_CASE("right images come with the left ones of frames later, without any before there are as many") {
    const auto all = frames("pair_off=3@1+1");
    for (int i = 20; i < 40; ++i) {
        CHECK(mean(all[static_cast<std::size_t>(i)].left) == pixel_of(i, 0));
        CHECK(mean(all[static_cast<std::size_t>(i)].right) == pixel_of(i - 3, 1));
    }
    check_untouched(all, 19);
    check_untouched(all, 40);
    const auto early = frames("pair_off");
    CHECK_FALSE(early[0].has_right);
    CHECK(early[1].has_right);
    CHECK(mean(early[1].right) == pixel_of(0, 1));
}

TEST_CASE("images turn with a vibration that they show, while it lasts, and not with one of samples") {
    const StereoRig rig = sim::euroc_rig();
    const CameraIntrinsics& k = rig.left.intrinsics();
    GreyImage stripes{.width = k.width, .height = k.height, .pixels = {}};
    for (int i = 0; i < k.width * k.height; ++i) {
        stripes.pixels.push_back(static_cast<std::uint8_t>(i % 16 < 8 ? 40 : 200));
    }
    for (const char* shown : {"samples", "images"}) {
        FaultSchedule schedule({parse_fault(std::string("vibration=flight,1,1,") + shown + "@1+1")}, {kBegin});
        FrameFaults faults(schedule, rig);
        std::vector<OwnedFrame> out;
        for (const int i : {19, 30, 31, 40}) {
            OwnedFrame frame;
            frame.stamp = frame.log_stamp = frame.output_stamp = {kBegin + i * kStep};
            frame.left = frame.right = stripes;
            frame.has_right = true;
            faults.change(frame, static_cast<std::uint64_t>(i) + 1);
            out.push_back(frame);
        }
        const bool turns = std::string(shown) == "images";
        CHECK(out[0].left.pixels == stripes.pixels);
        CHECK((out[1].left.pixels != stripes.pixels) == turns);
        CHECK((out[1].right.pixels != stripes.pixels) == turns);
        CHECK((out[1].left.pixels != out[2].left.pixels) == turns);
        CHECK(out[3].left.pixels == stripes.pixels);
        CHECK(schedule.hits() == std::vector<std::size_t>{turns ? 2U : 0U});
    }
}

TEST_CASE("the board is drawn into both images, and slides with time") {
    const StereoRig rig = sim::euroc_rig();
    FaultSchedule schedule({parse_fault("mover=0.5,1@1+1")}, {kBegin});
    FrameFaults faults(schedule, rig);
    const CameraIntrinsics& k = rig.left.intrinsics();
    const auto size = static_cast<std::size_t>(k.width * k.height);
    std::vector<OwnedFrame> out;
    for (const int i : {19, 20, 30, 40}) {
        OwnedFrame frame;
        frame.stamp = frame.log_stamp = frame.output_stamp = {kBegin + i * kStep};
        frame.left = frame.right = {.width = k.width, .height = k.height, .pixels = std::vector<std::uint8_t>(size, 5)};
        frame.has_right = true;
        faults.change(frame, static_cast<std::uint64_t>(i) + 1);
        out.push_back(frame);
    }
    const std::vector<std::uint8_t> empty(size, 5);
    CHECK(out[0].left.pixels == empty);
    CHECK(out[1].left.pixels != empty);
    CHECK(out[1].right.pixels != empty);
    CHECK(out[1].left.pixels != out[2].left.pixels);
    CHECK(out[3].left.pixels == empty);
    CHECK(schedule.hits() == std::vector<std::size_t>{2});
}

}  // namespace
}  // namespace facet::frame_faults_test
