// SPDX-License-Identifier: BSD-2-Clause
// `facet run` with the map of surfaces on its thread.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "app/run/live_run.h"
#include "tests/app/run/live_flight.h"

namespace facet::mapped_run_test {
namespace {

TEST_CASE("a run keeps the map on a thread of its own: mesh.ply is its surface, and estimates are the same bytes") {
    const test::TempDir dir;
    Rig rig;
    Vehicle vehicle = flight().vehicle(dir.file("out"));
    vehicle.config.map.enabled = true;
    LiveRun run(rig.clock, vehicle, {&rig.camera, nullptr, nullptr, &rig.imu}, {});
    (void)run_to_end(run);
    CHECK(run.failure().empty());
    for (const char* name : {"trajectory.csv", "covariance.csv", "health.csv", "planes.csv", "mesh_live.ply"}) {
        INFO(name);
        CHECK(test::read_file(dir.file(std::string("out/") + name)) ==
              test::read_file(flight().replayed() + "/" + name));
    }
    CHECK(test::read_file(dir.file("out/mesh_horizon.ply")) == test::read_file(flight().replayed() + "/mesh.ply"));
    const nlohmann::json json = nlohmann::json::parse(test::read_file(dir.file("out/summary.json")));
    const auto lost = json["live"]["drops"]["keyframes_not_mapped"].get<std::uint64_t>();
    const auto integrated = json["map"]["integrated"].get<std::uint64_t>();
    // Keyframes come faster here than in flight, and the map has what time is left.
    CHECK(integrated >= MapThread::kSlots);
    CHECK(integrated + json["map"]["skipped"].get<std::uint64_t>() + lost == rows(dir.file("out/mesh.csv")) - 1);
    const std::string mesh = test::read_file(dir.file("out/mesh.ply"));
    CHECK(mesh.find("comment facet: map") != std::string::npos);
    CHECK(mesh.size() > 100'000);
}

}  // namespace
}  // namespace facet::mapped_run_test
