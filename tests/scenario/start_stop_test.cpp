// SPDX-License-Identifier: BSD-2-Clause
// A thousand starts and stops in one process leave nothing behind: no memory, no file, no thread.
#include <malloc.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <memory>
#include <thread>

#include "app/pipeline/frame_pipeline.h"
#include "app/run/live_run.h"
#include "tests/support/paced_sources.h"
#include "tests/support/stereo_as_camera.h"
#include "tests/support/still_vehicle.h"
#include "tests/support/temp_dir.h"

namespace facet::start_stop_test {
namespace {

constexpr int kFrames = 4;  // of one start; the window begins with the first
constexpr int kSamplesPerFrame = 10;
constexpr double kFrameStep_s = 0.05;
constexpr double kImuStep_s = kFrameStep_s / kSamplesPerFrame;
constexpr int kLead = 2 * kSamplesPerFrame;  // samples before the first frame
constexpr std::size_t kSlack = 64 * 1024;    // bytes; a leak of a tenth of a kilobyte a start is found

/// Bytes that the program has from the heap; 0 under sanitizers, whose heap is another one.
std::size_t heap_bytes() {
    const auto info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

/// Entries of a folder below /proc/self: open files, or threads.
std::ptrdiff_t count_of(const char* what) {
    const std::filesystem::directory_iterator entries(std::filesystem::path("/proc/self") / what);
    return std::distance(begin(entries), end(entries));
}

ImuSample sample(int i) {
    return {.stamp = test::at(i * kImuStep_s), .w_B = {0.001, -0.002, 0.003}, .a_B = {0.0, 0.0, 9.81}};
}

double frame_time_s(int k) { return kImuStep_s * kLead + kFrameStep_s * k; }

Calibration calibration_of(const test::StillVehicle& vehicle) {
    Calibration calibration;
    calibration.rig = vehicle.rig;
    return calibration;
}

/// One start of the pipeline, from its construction to its end. @return the newest estimate
Estimate fly_once(const test::StillVehicle& vehicle, const Calibration& calibration) {
    const auto pipeline = std::make_unique<FramePipeline>();
    pipeline->configure({}, calibration);
    FrameResult result;
    int next = 0;
    for (int k = 0; k < kFrames; ++k) {
        for (; next <= kLead + k * kSamplesPerFrame; ++next) {
            pipeline->add_imu(sample(next));
        }
        const StereoFrame frame = vehicle.frame(frame_time_s(k));
        pipeline->add_frame(frame, frame.stamp, result);
        REQUIRE(result.status == Status::kOk);
    }
    return result.estimate;
}

TEST_CASE("a thousand starts of the estimator give one result and leave memory as it was") {
    constexpr int kStarts = 1000;
    constexpr int kWarm = 10;  // starts until caches of the library are filled
    const test::StillVehicle vehicle;
    const Calibration calibration = calibration_of(vehicle);
    const Estimate first = fly_once(vehicle, calibration);
    CHECK(first.health.tracked > 0);
    std::size_t before = 0;
    for (int start = 1; start < kStarts; ++start) {
        const Estimate again = fly_once(vehicle, calibration);
        REQUIRE(again.state.T_W_B().p == first.state.T_W_B().p);
        REQUIRE(again.state.T_W_B().q.coeffs() == first.state.T_W_B().q.coeffs());
        REQUIRE(again.health.tracked == first.health.tracked);
        before = start == kWarm ? heap_bytes() : before;
    }
    INFO(before << " bytes after " << kWarm << " starts, " << heap_bytes() << " after " << kStarts);
    CHECK(heap_bytes() <= before + kSlack);
}

/// The vehicle's images; none after the last one, as from a camera that is waited for.
class StillStereo final : public StereoSource {
public:
    explicit StillStereo(const test::StillVehicle& vehicle) : vehicle_(vehicle) {}
    Status start() override { return Status::kOk; }
    void stop() override {}
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return counters_; }
    std::string_view problem() const override { return {}; }
    Status next(Duration /*timeout*/, StereoFrame& frame) override {
        if (counters_.delivered == kFrames) {
            return Status::kNotReady;
        }
        frame = vehicle_.frame(frame_time_s(static_cast<int>(counters_.delivered++)));
        return Status::kOk;
    }

private:
    const test::StillVehicle& vehicle_;
    SourceCounters counters_;
};

class StillImu final : public ImuSource {
public:
    Status start() override { return Status::kOk; }
    void stop() override {}
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return counters_; }
    std::string_view problem() const override { return {}; }
    Status next(Duration /*timeout*/, ImuSample& out) override {
        out = sample(static_cast<int>(counters_.delivered++));
        return Status::kOk;
    }

private:
    SourceCounters counters_;
};

/// One live run with all its threads and files, stopped in flight. @return frames used
std::size_t run_once(const test::StillVehicle& still, const Vehicle& vehicle) {
    StillClock clock;
    StillStereo stereo(still);
    const CameraIntrinsics k = still.rig.left.intrinsics();
    StereoAsCamera<1> both(stereo, k.width, k.height);
    StillImu inertial;
    Pace pace{1, Duration::from_seconds(0.4)};
    PacedCamera camera{both, pace, 0};
    PacedImu imu{inertial, pace};
    LiveRun run(clock, vehicle, {&camera, nullptr, nullptr, &imu}, {});
    run.start();
    for (int waits = 0; run.frames() < kFrames && waits < 20'000; ++waits) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const RunSummary summary = run.stop();
    CHECK(summary.interrupted);
    CHECK(run.failure().empty());
    return summary.frames;
}

TEST_CASE("a hundred live runs, each stopped in flight, leave no memory, file or thread behind") {
    constexpr int kStarts = 100;
    constexpr int kWarm = 10;
    const test::TempDir dir;
    const test::StillVehicle still;
    Vehicle vehicle;
    vehicle.source = "scripted";
    vehicle.calibration = calibration_of(still);
    vehicle.cameras.side_by_side = true;
    vehicle.log.folder = dir.file("out");
    REQUIRE(run_once(still, vehicle) == kFrames);  // a thread sanitizer's own thread begins with the program's first
    const std::ptrdiff_t files = count_of("fd");
    const std::ptrdiff_t threads = count_of("task");
    std::size_t before = 0;
    for (int start = 2; start <= kStarts; ++start) {
        REQUIRE(run_once(still, vehicle) == kFrames);
        REQUIRE(count_of("fd") == files);
        REQUIRE(count_of("task") == threads);
        before = start == kWarm ? heap_bytes() : before;
    }
    INFO(before << " bytes after " << kWarm << " runs, " << heap_bytes() << " after " << kStarts);
    CHECK(heap_bytes() <= before + kSlack);
}

}  // namespace
}  // namespace facet::start_stop_test
