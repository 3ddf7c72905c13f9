// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/fault_injector.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

namespace facet::fault_injector_test {
namespace {

constexpr std::int64_t kBegin = 1'000'000'000'000;  // ns, first frame
constexpr std::int64_t kFrameStep = 50'000'000;     // 20 Hz
constexpr std::int64_t kImuStep = 5'000'000;        // 200 Hz
constexpr int kWidth = 16;
constexpr int kHeight = 8;

/// What came out, in order.
struct Output {
    std::vector<ImuSample> imu;
    std::vector<OwnedFrame> frames;
    std::vector<std::size_t> imu_before_frame;  ///< inertial samples that came before each frame
    std::vector<std::size_t> hits;
};

void drain(FaultInjector& injector, Output& output) {
    for (; injector.front() != nullptr; injector.pop()) {
        if (const auto* sample = std::get_if<ImuSample>(injector.front())) {
            output.imu.push_back(*sample);
        } else {
            output.frames.push_back(std::get<OwnedFrame>(*injector.front()));
            output.imu_before_frame.push_back(output.imu.size());
        }
    }
}

std::uint8_t pixel_of(int frame, int camera) { return static_cast<std::uint8_t>(40 + frame + 100 * camera); }

/// A log of `frames` frames with inertial samples from one frame step before to one after, as AslDataset gives it.
Output inject(const std::vector<std::string>& specs, int frames = 100) {
    std::vector<Fault> faults;
    for (const std::string& spec : specs) {
        faults.push_back(parse_fault(spec));
    }
    FaultInjector injector(faults, ImuNoise{}, {}, {kBegin});
    Output output;
    for (int i = -10; i <= 10 * frames; ++i) {
        injector.add(ImuSample{.stamp = {kBegin + i * kImuStep}, .w_B = {0.0, 0.0, 0.1}, .a_B = {0.0, 0.0, 9.81}});
        drain(injector, output);
        if (i >= 0 && i % 10 == 0 && i / 10 < frames) {
            const int k = i / 10;
            const std::vector<std::uint8_t> left(kWidth * kHeight, pixel_of(k, 0));
            const std::vector<std::uint8_t> right(kWidth * kHeight, pixel_of(k, 1));
            injector.add(StereoFrame{.stamp = {kBegin + k * kFrameStep},
                                     .left = {left.data(), kWidth, kHeight, kWidth},
                                     .right = {right.data(), kWidth, kHeight, kWidth}});
            drain(injector, output);
        }
    }
    injector.finish();
    drain(injector, output);
    output.hits = injector.hits();
    return output;
}

int mean_pixel(const GreyImage& image) {
    int sum = 0;
    for (const std::uint8_t p : image.pixels) {
        sum += p;
    }
    return sum / (kWidth * kHeight);
}

bool is_untouched(const OwnedFrame& frame) {
    const int k = static_cast<int>((frame.log_stamp.ns - kBegin) / kFrameStep);
    return frame.has_right && mean_pixel(frame.left) == pixel_of(k, 0) && mean_pixel(frame.right) == pixel_of(k, 1) &&
           frame.stamp == frame.log_stamp && frame.output_stamp == frame.log_stamp;
}

/// Frames whose log stamp is in [from, to) s after the first.
std::vector<OwnedFrame> frames_within(const Output& output, double from_s, double to_s) {
    std::vector<OwnedFrame> found;
    std::copy_if(output.frames.begin(), output.frames.end(), std::back_inserter(found), [&](const OwnedFrame& f) {
        const Duration t = f.log_stamp - Timestamp{kBegin};
        return t >= Duration::from_seconds(from_s) && t < Duration::from_seconds(to_s);
    });
    return found;
}

/// All frames outside [from, to) s are as the log had them, and how many there are.
std::size_t untouched_outside(const Output& output, double from_s, double to_s) {
    std::size_t count = 0;
    for (const OwnedFrame& f : output.frames) {
        const Duration t = f.log_stamp - Timestamp{kBegin};
        if (t < Duration::from_seconds(from_s) || t >= Duration::from_seconds(to_s)) {
            CHECK(is_untouched(f));
            ++count;
        }
    }
    return count;
}

TEST_CASE("without faults everything comes out as it went in") {
    const Output output = inject({});
    CHECK(output.imu.size() == 1011);
    REQUIRE(output.frames.size() == 100);
    CHECK(untouched_outside(output, 0.0, 0.0) == 100);
    for (std::size_t k = 0; k < 100; ++k) {
        CHECK(output.imu_before_frame[k] == 11 + 10 * k);
    }
}

TEST_CASE("black, bright and missing images are confined to their time") {
    const Output black = inject({"blackout@2+1"});
    CHECK(untouched_outside(black, 2.0, 3.0) == 80);
    for (const OwnedFrame& f : frames_within(black, 2.0, 3.0)) {
        CHECK(mean_pixel(f.left) < 4);
        CHECK(mean_pixel(f.right) < 4);
        CHECK(f.left.pixels != f.right.pixels);
    }
    CHECK(black.hits == std::vector<std::size_t>{20});

    const Output bright = inject({"flash@2+0.3"});
    CHECK(untouched_outside(bright, 2.0, 2.3) == 94);
    for (const OwnedFrame& f : frames_within(bright, 2.0, 2.3)) {
        CHECK(mean_pixel(f.left) == 255);
    }

    const Output no_right = inject({"no_right@2+0.5"});
    CHECK(untouched_outside(no_right, 2.0, 2.5) == 90);
    for (const OwnedFrame& f : frames_within(no_right, 2.0, 2.5)) {
        CHECK(f.view().right.empty());
        CHECK(mean_pixel(f.left) == pixel_of(static_cast<int>((f.log_stamp.ns - kBegin) / kFrameStep), 0));
    }

    const Output no_left = inject({"no_left@2+0.5"});
    CHECK(untouched_outside(no_left, 2.0, 2.5) == 90);
    CHECK(no_left.frames.size() == 100);
    for (const OwnedFrame& f : frames_within(no_left, 2.0, 2.5)) {
        CHECK(f.view().left.empty());
        CHECK_FALSE(f.view().right.empty());
    }
    CHECK(inject({"no_left@2+0.5", "no_right@2+0.5"}).frames.size() == 90);
}

TEST_CASE("a frozen camera repeats its first image with new stamps, each time again") {
    const Output output = inject({"freeze@1+0.5", "freeze@3+0.5"});
    CHECK(untouched_outside(inject({"freeze@1+0.5"}), 1.0, 1.5) == 90);
    for (const auto& [from, frame] : {std::pair{1.0, 20}, std::pair{3.0, 60}}) {
        const auto frozen = frames_within(output, from, from + 0.5);
        REQUIRE(frozen.size() == 10);
        for (const OwnedFrame& f : frozen) {
            CHECK(mean_pixel(f.left) == pixel_of(frame, 0));
            CHECK(mean_pixel(f.right) == pixel_of(frame, 1));
            CHECK(f.stamp == f.log_stamp);
        }
    }
    CHECK(is_untouched(frames_within(output, 2.0, 2.05).front()));
}

TEST_CASE("dropped frames have their share, and are the same each time but for another seed") {
    const Output output = inject({"drop_frames=0.1"}, 1000);
    CHECK(output.frames.size() > 870);
    CHECK(output.frames.size() < 930);
    CHECK(output.hits[0] == 1000 - output.frames.size());
    const auto stamps = [](const Output& o) {
        std::vector<std::int64_t> all;
        for (const OwnedFrame& f : o.frames) {
            all.push_back(f.stamp.ns);
        }
        return all;
    };
    CHECK(stamps(output) == stamps(inject({"drop_frames=0.1"}, 1000)));
    CHECK(stamps(output) != stamps(inject({"drop_frames=0.1,2"}, 1000)));
    CHECK(inject({"drop_frames=1"}).frames.empty());
    CHECK(inject({"drop_frames=0"}).frames.size() == 100);
}

TEST_CASE("offset images are reported and filed under shifted stamps, and wait for inertial samples") {
    const Output late = inject({"time_offset=0.012"});
    REQUIRE(late.frames.size() == 100);
    for (std::size_t k = 0; k < late.frames.size(); ++k) {
        const OwnedFrame& f = late.frames[k];
        CHECK((f.stamp - f.log_stamp).ns == 12'000'000);
        CHECK(f.output_stamp == f.stamp);
        CHECK(late.imu[late.imu_before_frame[k] - 1].stamp >= f.stamp);
        CHECK(late.imu[late.imu_before_frame[k] - 2].stamp < f.stamp);
    }
    const Output early = inject({"time_offset=-0.012"});
    CHECK((early.frames[0].stamp - early.frames[0].log_stamp).ns == -12'000'000);
}

TEST_CASE("a jump of the clock moves all stamps, but not those of the files") {
    const Output output = inject({"clock_jump=5@2"});
    REQUIRE(output.frames.size() == 100);
    for (std::size_t k = 0; k < output.frames.size(); ++k) {
        const OwnedFrame& f = output.frames[k];
        CHECK((f.stamp - f.log_stamp).ns == (k < 40 ? 0 : 5'000'000'000));
        CHECK(f.output_stamp == f.log_stamp);
        CHECK(output.imu[output.imu_before_frame[k] - 1].stamp == f.stamp);
    }
    CHECK((output.imu[410].stamp - output.imu[409].stamp).ns == 5'005'000'000);
    // Backwards, no frame waits: to call its stamp old is the estimator's business.
    const Output back = inject({"clock_jump=-1@2"});
    REQUIRE(back.frames.size() == 100);
    CHECK(back.imu_before_frame[40] == 411);
}

TEST_CASE("a short gap delays frames, a long one only so long") {
    const Output brief = inject({"imu_gap@2.02+0.1"});
    CHECK(brief.imu.size() == 1011 - 20);
    REQUIRE(brief.frames.size() == 100);
    for (std::size_t k = 0; k < brief.frames.size(); ++k) {
        CHECK(brief.imu[brief.imu_before_frame[k] - 1].stamp >= brief.frames[k].stamp);
    }
    CHECK(brief.imu_before_frame[41] == brief.imu_before_frame[42]);  // both came with the first sample after the gap

    const Output deaf = inject({"imu_gap@2"});
    REQUIRE(deaf.frames.size() == 100);
    CHECK(deaf.imu.size() == 410);
    CHECK(deaf.hits[0] == 601);
}

TEST_CASE("inertial samples are clipped, made noisy and doubled") {
    const Output clipped = inject({"clip=80,9@2+0.1", "imu_noise=10@2+0.1"});
    for (const ImuSample& s : clipped.imu) {
        const double t = (s.stamp - Timestamp{kBegin}).seconds();
        const bool is_clipped = t > 1.9999 && t < 2.0999;
        CHECK(s.a_B == (is_clipped ? Eigen::Vector3d(80.0, -80.0, 80.0) : Eigen::Vector3d(0.0, 0.0, 9.81)));
        CHECK(s.w_B == (is_clipped ? Eigen::Vector3d(9.0, -9.0, 9.0) : Eigen::Vector3d(0.0, 0.0, 0.1)));
    }

    const Output noisy = inject({"imu_noise=10"}, 1000);
    double gyro = 0.0;
    double accel = 0.0;
    int count = 0;
    for (const ImuSample& s : noisy.imu) {
        if (s.stamp.ns >= kBegin) {
            gyro += (s.w_B - Eigen::Vector3d(0.0, 0.0, 0.1)).squaredNorm() / 3.0;
            accel += (s.a_B - Eigen::Vector3d(0.0, 0.0, 9.81)).squaredNorm() / 3.0;
            ++count;
        }
    }
    const ImuNoise noise;
    const double root_rate = std::sqrt(noise.rate_hz);
    CHECK(std::sqrt(gyro / count) == Approx(10.0 * noise.gyro_noise_rad_per_s_per_sqrt_hz * root_rate).epsilon(0.03));
    CHECK(std::sqrt(accel / count) == Approx(10.0 * noise.accel_noise_m_per_s2_per_sqrt_hz * root_rate).epsilon(0.03));

    const Output doubled = inject({"imu_duplicate@2+0.1"});
    REQUIRE(doubled.imu.size() == 1031);
    CHECK(doubled.imu[410].stamp == doubled.imu[411].stamp);
}

TEST_CASE("faults work together and idle ones are known") {
    const Output output = inject(
        {"freeze@1+1", "blackout@1.5+0.2", "no_right@1.2+0.1", "time_offset=0.005", "clock_jump=3@1.6", "clip@99"});
    REQUIRE(output.frames.size() == 100);
    CHECK(mean_pixel(output.frames[24].left) == pixel_of(20, 0));
    CHECK_FALSE(output.frames[24].has_right);
    CHECK(mean_pixel(output.frames[31].left) < 4);
    CHECK(mean_pixel(output.frames[36].left) == pixel_of(20, 0));
    CHECK((output.frames[36].stamp - output.frames[36].log_stamp).ns == 3'005'000'000);
    CHECK((output.frames[36].output_stamp - output.frames[36].log_stamp).ns == 5'000'000);
    CHECK(output.hits[5] == 0);
    CHECK(output.hits[3] == 100);
}

TEST_CASE("a bias begins anywhere, walks as calibrated, and was there before the first frame") {
    double first = 0.0;
    double walked = 0.0;
    constexpr int kSeeds = 40;
    for (int seed = 1; seed <= kSeeds; ++seed) {
        const Output output = inject({"imu_bias=1," + std::to_string(seed)}, 20);
        first += (output.imu.front().w_B - Eigen::Vector3d(0.0, 0.0, 0.1)).squaredNorm() / 3.0;
        walked += (output.imu.back().a_B - output.imu.front().a_B).squaredNorm() / 3.0;
        CHECK((output.imu[100].a_B - output.imu[99].a_B).norm() < 0.01);
        CHECK(output.hits.front() == output.imu.size());
    }
    CHECK(std::sqrt(first / kSeeds) == Approx(0.03).epsilon(0.25));
    const double seconds = 20 * 0.05 + 0.05;
    CHECK(std::sqrt(walked / kSeeds) ==
          Approx(ImuNoise{}.accel_walk_m_per_s3_per_sqrt_hz * std::sqrt(seconds)).epsilon(0.25));
}

TEST_CASE("the IMU's axes are wrong by a constant matrix, drawn from the seed") {
    double squares = 0.0;
    constexpr int kSeeds = 60;
    for (int seed = 1; seed <= kSeeds; ++seed) {
        const Output output = inject({"imu_scale=2," + std::to_string(seed)}, 2);
        const Output again = inject({"imu_scale=2," + std::to_string(seed)}, 2);
        const Eigen::Vector3d change = output.imu.front().w_B - Eigen::Vector3d(0.0, 0.0, 0.1);
        CHECK(output.imu.back().w_B == output.imu.front().w_B);
        CHECK(output.imu.front().w_B == again.imu.front().w_B);
        CHECK(output.hits.front() == output.imu.size());
        squares += change.squaredNorm() / 3.0;
    }
    CHECK(std::sqrt(squares / kSeeds) == Approx(2.0 * 0.005 * 0.1).epsilon(0.25));
}

TEST_CASE("rotors shake the inertial samples while they are asked to, and nothing else") {
    const Output output = inject({"vibration=flight,3@1+2"});
    CHECK(untouched_outside(output, 0.0, 0.0) == 100);
    double inside = 0.0;
    for (const ImuSample& sample : output.imu) {
        const Duration t = sample.stamp - Timestamp{kBegin};
        const double change = std::abs(sample.a_B.x());
        if (t < Duration::from_seconds(1.0) || t >= Duration::from_seconds(3.0)) {
            CHECK(change == 0.0);
        } else {
            inside += change * change / 400.0;
        }
    }
    CHECK(std::sqrt(inside) == Approx(0.99).epsilon(0.2));
    CHECK(output.hits == std::vector<std::size_t>{400});
    CHECK(inject({"vibration=flight,4@1+2"}).imu[300].a_B != output.imu[300].a_B);
    const Output shown = inject({"vibration=flight,3,1,images@1+2"});
    for (std::size_t i = 0; i < output.imu.size(); ++i) {
        CHECK(shown.imu[i].w_B == output.imu[i].w_B);
        CHECK(shown.imu[i].a_B == output.imu[i].a_B);
    }
}

TEST_CASE("a sensor at half its rate gives every second sample") {
    const Output frames = inject({"frame_thin@2+1"});
    CHECK(untouched_outside(frames, 2.0, 3.0) == 80);
    CHECK(frames_within(frames, 2.0, 3.0).size() == 10);
    CHECK(frames.hits == std::vector<std::size_t>{10});
    const Output thin = inject({"frame_thin=5@2+1"});
    CHECK(frames_within(thin, 2.0, 3.0).size() == 4);
    const Output imu = inject({"imu_thin@2+1"});
    CHECK(imu.imu.size() == 1011 - 100);
    CHECK(imu.frames.size() == 100);
    CHECK(imu.hits == std::vector<std::size_t>{100});
}

TEST_CASE("frames come twice with one stamp") {
    const Output output = inject({"frame_duplicate@2+1"});
    REQUIRE(output.frames.size() == 120);
    for (std::size_t k = 40; k < 80; k += 2) {
        CHECK(output.frames[k].stamp == output.frames[k + 1].stamp);
        CHECK(output.frames[k].left.pixels == output.frames[k + 1].left.pixels);
    }
    const std::size_t some = inject({"frame_duplicate=0.5"}).frames.size();
    CHECK(some > 130);
    CHECK(some < 170);
}

TEST_CASE("samples out of order come in pairs, and none is lost") {
    const Output frames = inject({"frame_order@2.05"});
    REQUIRE(frames.frames.size() == 100);
    CHECK(frames.frames[40].log_stamp.ns == kBegin + 40 * kFrameStep);
    CHECK(frames.frames[41].log_stamp.ns == kBegin + 42 * kFrameStep);
    CHECK(frames.frames[42].log_stamp.ns == kBegin + 41 * kFrameStep);
    CHECK(frames.frames[99].log_stamp.ns == kBegin + 99 * kFrameStep);  // the last has none to overtake it

    const Output imu = inject({"imu_order@2+1"});
    REQUIRE(imu.imu.size() == 1011);
    CHECK(imu.imu[409].stamp.ns == kBegin + 399 * kImuStep);
    CHECK(imu.imu[410].stamp.ns == kBegin + 401 * kImuStep);
    CHECK(imu.imu[411].stamp.ns == kBegin + 400 * kImuStep);
    CHECK(imu.imu[1010].stamp.ns == kBegin + 1000 * kImuStep);
    CHECK(inject({"imu_order"}, 3).imu.size() == 41);  // an odd number: the last comes out at the end
}

TEST_CASE("the clock of one sensor jumps, and the other's does not") {
    const Output frames = inject({"frame_jump=-3600@2+1"});
    REQUIRE(frames.frames.size() == 100);
    CHECK(frames.imu.size() == 1011);
    for (const OwnedFrame& f : frames_within(frames, 2.0, 3.0)) {
        CHECK((f.stamp - f.log_stamp).ns == -3'600'000'000'000);
        CHECK(f.output_stamp == f.log_stamp);
    }
    CHECK(untouched_outside(frames, 2.0, 3.0) == 80);
    CHECK(inject({"frame_jump=3600@2+1"}).frames.size() == 100);  // in the end: none waits for ever

    const Output imu = inject({"imu_jump=-1@2+1"});
    REQUIRE(imu.imu.size() == 1011);
    CHECK((imu.imu[410].stamp - imu.imu[409].stamp).ns == kImuStep - 1'000'000'000);
    CHECK(imu.frames.size() == 100);
    CHECK(untouched_outside(imu, 0.0, 0.0) == 100);
}

}  // namespace
}  // namespace facet::fault_injector_test
