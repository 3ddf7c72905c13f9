// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/status_text.h"

#include <algorithm>
#include <catch2/catch.hpp>

namespace facet::status_text_test {
namespace {

RunStatus example() {
    RunStatus status;
    status.uptime_s = 61.0;
    status.rate_hz = 19.96;
    status.late = 2;
    status.overruns = 3;
    status.outputs_dropped = 4;
    status.frame.frames = 1200;
    status.frame.health.state = TrackingState::kDegraded;
    status.frame.health.reasons = kReasonFewStereo;
    status.frame.health.quality = 44;
    status.frame.health.tracked = 187;
    status.frame.planes = 5;
    status.frame.latency_median_ms = 31.25;
    status.frame.latency_p99_ms = 48.5;
    status.frame.events = {"imu: bus-off"};
    status.sources = {{"imu", {.delivered = 12000, .lost = 7, .errors = 1}, 0, 0}};
    return status;
}

TEST_CASE("the screen shows rate, latency, state, quality, features, planes, drops and each source") {
    const std::string screen = status_screen(example(), "vehicle.yaml");
    for (const char* part : {"vehicle.yaml", "DEGRADED: few_stereo", "quality 44", "20.0 frames/s", "31.2 ms median",
                             "48.5 ms p99", "187 tracked", "5 planes", "2 late frames", "3 overruns", "4 outputs",
                             "imu             12000        7", "imu: bus-off"}) {
        INFO(part);
        CHECK(screen.find(part) != std::string::npos);
    }
    CHECK(std::count(screen.begin(), screen.end(), '\n') <= 24);
}

TEST_CASE("the line says the same in short") {
    CHECK(status_line(example()) ==
          "DEGRADED quality 44, 20.0 frames/s, latency 31.2/48.5 ms, 187 features, 5 planes, 2 late, 3 overruns, "
          "1 source errors");
}

}  // namespace
}  // namespace facet::status_text_test
