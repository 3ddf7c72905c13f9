// SPDX-License-Identifier: BSD-2-Clause
// A live run that ends without a word, and the next one, which goes on from what it has kept, with the sensors that are
// there.
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>
#include <thread>

#include "app/run/state_keeper.h"
#include "tests/app/run/live_flight.h"

namespace facet::resumed_run_test {
namespace {

/// Where the first run is taken to have been.
KeptState somewhere() {
    KeptState kept;
    kept.state.q_W_B = Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitZ());
    kept.state.p_W_B = {10.0, -20.0, 3.0};
    kept.sigma.setConstant(0.01);
    kept.calibration.sigma.setConstant(1e-3);
    return kept;
}

/// The first pose of a TUM file.
Eigen::Vector3d first_place(const std::string& path) {
    std::istringstream text(test::read_file(path));
    std::string line;
    while (std::getline(text, line) && line.starts_with('#')) {
    }
    std::istringstream fields(line);
    double stamp_s = 0.0;
    Eigen::Vector3d p = Eigen::Vector3d::Constant(NAN);
    fields >> stamp_s >> p.x() >> p.y() >> p.z();
    return p;
}

TEST_CASE("a run that ends without a word is gone on from in flight, with its place announced as a jump") {
    const test::TempDir dir;
    const Vehicle vehicle = flight().vehicle("");
    StateKeeper keeper(dir.path(), vehicle.calibration, "boot");
    KeptState state;
    {
        Rig rig;
        LiveRun run(rig.clock, vehicle, {&rig.camera, nullptr, nullptr, &rig.imu}, {});
        REQUIRE(ok(run.resume(somewhere(), 0.0)));
        run.keep_states();
        run.start();
        for (int waits = 0; !run.take_state(state) && waits < 20'000; ++waits) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        REQUIRE(keeper.keep(state, Timestamp{1'000'000'000}).empty());
    }  // not stopped: as a program that is killed
    CHECK((state.state.p_W_B - somewhere().state.p_W_B).norm() < 0.1);

    std::string refusal;
    const auto found = StateKeeper(dir.path(), vehicle.calibration, "boot").load(Timestamp{1'500'000'000}, refusal);
    REQUIRE(found);
    AslSourceOptions later = flight().source();
    later.log.start = Duration::from_seconds(1.6);  // in motion
    Rig rig(later);
    const Vehicle next = flight().vehicle(dir.file("next"));
    LiveRun run(rig.clock, next, {&rig.camera, nullptr, nullptr, &rig.imu}, {});
    REQUIRE(ok(run.resume(found->state, found->elapsed_s)));
    const RunSummary summary = run_to_end(run);
    CHECK(summary.last.health.state == TrackingState::kTracking);
    // What is sent is one more than the last counter of before: ResetCount announces the jump, nothing else does.
    CHECK(summary.last.health.reset_counter == 0);
    // It has flown half a metre since at most; half a second is a metre of what it may have done.
    const double off_m = (first_place(dir.file("next/trajectory.tum")) - state.state.p_W_B).norm();
    CAPTURE(off_m);
    CHECK(off_m < 0.5);
    CHECK(std::sqrt(summary.last.covariance(3, 3)) > 0.5);
}

/// A source that is not there.
template <class Base, class Sample>
class Absent final : public Base {
public:
    Status start() override {
        ++attempts;
        return Status::kNotFound;
    }
    void stop() override {}
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return {}; }
    std::string_view problem() const override { return "/dev/x: cannot be opened: No such file or directory"; }
    Status next(Duration, Sample&) override { return Status::kNotReady; }
    std::atomic<int> attempts{0};
};

TEST_CASE("a restart in the air goes on with the inertial sensor and either camera, and waits for the rest") {
    const bool left_is_there = GENERATE(true, false);
    CAPTURE(left_is_there);
    const test::TempDir dir;
    StillClock clock;
    const std::atomic<bool> go{true};
    ViewCamera<5> view(clock, left_is_there, go);
    AslImuSource log_imu(clock, flight().source());
    Pace pace(1, Duration::from_seconds(0.4));
    PacedCamera camera(view, pace, 0);
    PacedImu imu(log_imu, pace);
    Absent<CameraSource, CameraFrame> absent;
    Absent<TriggerSource, TriggerEdge> trigger;
    Vehicle vehicle = flight().vehicle(dir.file("out"));
    vehicle.cameras.side_by_side = false;
    vehicle.trigger.emplace();
    const RunSources sources =
        left_is_there ? RunSources{&camera, &absent, &trigger, &imu} : RunSources{&absent, &camera, &trigger, &imu};
    {
        LiveRun on_the_ground(clock, vehicle, sources, {});
        CHECK_THROWS_WITH(on_the_ground.start(), Catch::Contains("/dev/x: cannot be opened"));
    }
    LiveRun run(clock, vehicle, sources, {});
    run.begin_in_flight();
    run.start();
    for (int i = 0; i < 2000 && (run.frames() < 20 || absent.attempts < 4); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    const RunSummary summary = run.stop();
    CHECK(run.failure().empty());
    CHECK(summary.frames >= 20);
    CHECK(summary.last.health.state != TrackingState::kLost);
    CHECK(absent.attempts >= 4);
    CHECK(trigger.attempts >= 4);
    const std::string log = test::read_file(dir.file("out/warnings.txt"));
    CHECK(log.find("camera: /dev/x: cannot be opened: No such file or directory; begun without it in flight") !=
          std::string::npos);
    CHECK(log.find("trigger: /dev/x") != std::string::npos);
}

/// An inertial sensor that can be started at the fourth attempt.
class LateImu final : public ImuSource {
public:
    explicit LateImu(ImuSource& imu) : imu_(imu) {}
    Status start() override { return ++attempts_ < 4 ? Status::kNotFound : imu_.start(); }
    void stop() override { imu_.stop(); }
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return imu_.counters(); }
    std::string_view problem() const override { return "/dev/ttyACM0: cannot be opened: No such file or directory"; }
    Status next(Duration timeout, ImuSample& sample) override { return imu_.next(timeout, sample); }

private:
    ImuSource& imu_;
    int attempts_ = 0;
};

TEST_CASE("a restart in the air waits for an inertial sensor that is not there") {
    const test::TempDir dir;
    Rig rig;
    LateImu imu(rig.imu);
    const Vehicle vehicle = flight().vehicle(dir.file("out"));
    {
        LiveRun on_the_ground(rig.clock, vehicle, {&rig.camera, nullptr, nullptr, &imu}, {});
        CHECK_THROWS_WITH(on_the_ground.start(), Catch::Contains("imu: /dev/ttyACM0: cannot be opened"));
    }
    LiveRun run(rig.clock, vehicle, {&rig.camera, nullptr, nullptr, &imu}, {});
    run.begin_in_flight();
    const RunSummary summary = run_to_end(run);
    CHECK(run.failure().empty());
    CHECK(summary.frames >= 20);
    CHECK(test::read_file(dir.file("out/warnings.txt")).find("ttyACM0") != std::string::npos);
}

TEST_CASE("without any camera there is nothing to begin with, in flight neither") {
    Rig rig;
    Absent<CameraSource, CameraFrame> left;
    Absent<CameraSource, CameraFrame> right;
    const Vehicle vehicle = flight().vehicle("");
    LiveRun run(rig.clock, vehicle, {&left, &right, nullptr, &rig.imu}, {});
    run.begin_in_flight();
    CHECK_THROWS_WITH(run.start(), Catch::StartsWith("no camera can be started: /dev/x"));
}

}  // namespace
}  // namespace facet::resumed_run_test
