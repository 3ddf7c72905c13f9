// SPDX-License-Identifier: BSD-2-Clause
// A live run that is killed, and the one after it.
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>

#include "app/lab/eval/trajectory.h"
#include "platform/linux/linux_clock.h"
#include "tests/app/run/live_flight.h"

namespace facet::killed_run_test {
namespace {

/// Flies with a log folder that has a folder a flight, and waits to be killed once every frame has been written for
/// more than a second. Tells so by closing `ready`.
[[noreturn]] void fly_until_killed(const std::string& logs, int ready) {
    LinuxClock clock;
    AslStereoSource stereo(clock, flight().source());
    AslImuSource log_imu(clock, flight().source());
    const CameraIntrinsics k = flight().vehicle("").calibration.rig.left.intrinsics();
    StereoAsCamera<1> log_camera(stereo, k.width, k.height);
    Pace pace(1, Duration::from_seconds(0.4));
    PacedCamera camera(log_camera, pace, 0);
    PacedImu imu(log_imu, pace);
    Vehicle vehicle = flight().vehicle(logs);
    vehicle.log.by_flight = true;
    LiveRun run(clock, vehicle, {&camera, nullptr, nullptr, &imu}, {});
    run.start();
    while (!run.ended()) {
        clock.sleep(Duration::from_seconds(0.01));
    }
    clock.sleep(Duration::from_seconds(1.5));
    close(ready);
    for (;;) {
        clock.sleep(Duration::from_seconds(1.0));
    }
}

TEST_CASE("a flight that was killed keeps its log when the program starts again") {
    const test::TempDir dir;
    (void)flight();
    std::array<int, 2> pipe{};
    REQUIRE(::pipe(pipe.data()) == 0);
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        close(pipe[0]);
        fly_until_killed(dir.file("log"), pipe[1]);
    }
    close(pipe[1]);
    char byte = 0;
    REQUIRE(read(pipe[0], &byte, 1) == 0);  // until the child has closed its end
    close(pipe[0]);
    REQUIRE(kill(child, SIGKILL) == 0);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
    const std::string crashed = dir.file("log/flight_00001/");
    const Trajectory before = read_tum(crashed + "trajectory.tum.part");
    REQUIRE(before.size() > 30);
    const std::string bytes = test::read_file(crashed + "trajectory.tum.part");

    Rig rig;
    Vehicle vehicle = flight().vehicle(dir.file("log"));
    vehicle.log.by_flight = true;
    vehicle.log.keep_mb = 1;
    LiveRun run(rig.clock, vehicle, {&rig.camera, nullptr, nullptr, &rig.imu}, {});
    const RunSummary summary = run_to_end(run);
    CHECK(run.failure().empty());
    CHECK(run.folder() == dir.file("log/flight_00002"));
    CHECK(test::read_file(crashed + "trajectory.tum.part") == bytes);
    CHECK(rows(crashed + "health.csv.part") > 30);
    CHECK(read_tum(run.folder() + "/trajectory.tum").size() == summary.estimates);
    CHECK_FALSE(std::filesystem::exists(run.folder() + "/trajectory.tum.part"));
}

}  // namespace
}  // namespace facet::killed_run_test
