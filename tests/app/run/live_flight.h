// SPDX-License-Identifier: BSD-2-Clause
// A short simulated flight, its replay, and sources that play it to a live run.
#pragma once

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "app/lab/replay/replay.h"
#include "app/lab/sim/simulate.h"
#include "app/run/live_run.h"
#include "tests/support/asl_sources.h"
#include "tests/support/paced_sources.h"
#include "tests/support/stereo_as_camera.h"
#include "tests/support/temp_dir.h"

namespace facet {

/// Three seconds in the room, the first one standing; coarse rendering. Made once.
class Flight {
public:
    Flight() {
        sim::SimOptions options;
        options.out = dir_.path();
        options.duration_s = 3.0;
        options.stand_s = 1.0;
        options.samples = 1;
        options.texture_size = 256;
        sim::SimSummary summary;
        std::string error;
        REQUIRE(ok(sim::simulate(
            options, [](int, int) {}, summary, error)));
        vehicle_.source = "simulated";
        vehicle_.calibration = load_euroc_calibration(folder() + "/mav0");
        vehicle_.config.imu_noise = vehicle_.calibration.noise;
        vehicle_.config.regularity.mode = RegularityMode::kSpr;
        vehicle_.config.map.enabled = false;  // what of it is done by when depends on the threads
        vehicle_.cameras.side_by_side = true;
        ReplayOptions replay;
        replay.dataset = folder();
        replay.out = replayed();
        replay.config = vehicle_.config;
        replay.calibration = vehicle_.calibration;
        replay.show_progress = false;
        run_ = run_replay(replay, false);
    }
    std::string folder() const { return dir_.path(); }
    std::string replayed() const { return dir_.file("replay"); }
    const RunSummary& run() const { return run_; }
    Vehicle vehicle(const std::string& out) const {
        Vehicle vehicle = vehicle_;
        vehicle.log.folder = out;
        return vehicle;
    }
    AslSourceOptions source() const {
        AslSourceOptions options;
        options.folder = folder();
        options.pace.as_fast_as_asked = true;
        return options;
    }

private:
    test::TempDir dir_;
    Vehicle vehicle_;
    RunSummary run_;
};

inline const Flight& flight() {
    static const Flight made;
    return made;
}

/// Runs until the sources end.
inline RunSummary run_to_end(LiveRun& run) {
    run.start();
    while (!run.ended()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        (void)run.status();
    }
    return run.stop();
}

inline std::size_t rows(const std::string& path) {
    const std::string text = test::read_file(path);
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// The flight as a side-by-side camera and an IMU that wait for the estimator: every frame is used, as in a replay.
struct Rig {
    explicit Rig(AslSourceOptions log = flight().source()) : options(std::move(log)) {}

    AslSourceOptions options;
    StillClock clock;
    AslStereoSource stereo{clock, options};
    AslImuSource log_imu{clock, options};
    StereoAsCamera<1> log_camera{stereo, flight().vehicle("").calibration.rig.left.intrinsics().width,
                                 flight().vehicle("").calibration.rig.left.intrinsics().height};
    /// More than the gap in inertial samples below; less than the loop holds samples back for a frame.
    Pace pace{1, Duration::from_seconds(0.4)};
    PacedCamera camera{log_camera, pace, 0};
    PacedImu imu{log_imu, pace};
};

/// One view of the log's pairs as a camera of its own.
template <std::size_t kSlots = 1>
class ViewCamera final : public CameraSource {
public:
    ViewCamera(Clock& clock, bool is_left, const std::atomic<bool>& go,
               const AslSourceOptions& options = flight().source())
        : stereo_(clock, options), is_left_(is_left), go_(go) {
        const CameraIntrinsics k = flight().vehicle("").calibration.rig.left.intrinsics();
        both_ = std::make_unique<StereoAsCamera<kSlots>>(stereo_, k.width, k.height);
    }
    Status start() override { return both_->start(); }
    void stop() override { both_->stop(); }
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return both_->counters(); }
    std::string_view problem() const override { return both_->problem(); }
    Status next(Duration timeout, CameraFrame& frame) override {
        if (!go_) {
            return Status::kNotReady;
        }
        FACET_TRY(both_->next(timeout, frame));
        frame.image.width /= 2;
        frame.image.data += is_left_ ? 0 : frame.image.width;
        return Status::kOk;
    }

private:
    AslStereoSource stereo_;
    bool is_left_;
    const std::atomic<bool>& go_;
    std::unique_ptr<StereoAsCamera<kSlots>> both_;
};

}  // namespace facet
