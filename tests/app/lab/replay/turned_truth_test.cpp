// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/turned_truth.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <vector>

#include "drivers/replay_asl/ground_truth.h"
#include "estimator/geometry/so3.h"
#include "tests/support/temp_dir.h"

namespace facet::turned_truth_test {
namespace {

constexpr std::int64_t kBegin = 1'000'000'000'000;

std::vector<GroundTruthState> states_of(const std::string& path) {
    std::vector<GroundTruthState> states;
    std::string error;
    REQUIRE(ok(read_ground_truth(path, {}, states, error)));
    return states;
}

TEST_CASE("where images turn with a vibration the true attitudes do, from its start on, and nothing else") {
    const test::TempDir dir;
    const std::string table = dir.file("truth.csv");
    dir.write("truth.csv",
              "1000000000000,1,2,3,0.6,0.8,0,0,4,5,6,7,8,9,10,11,12\n"
              "1000500000000,1,2,3,0,0,0.6,0.8,4,5,6,7,8,9,10,11,12\n"
              "1001200000000,1,2,4,0.6,0.8,0,0,4,5,6,7,8,9,10,11,12\n");
    FaultInjector injector({parse_fault("vibration=flight,1,1,images@0.4")}, {}, {}, {kBegin});
    write_turned_truth(table, injector, dir.file("turned.csv"));
    const auto before = states_of(table);
    const auto after = states_of(dir.file("turned.csv"));
    REQUIRE(after.size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(after[i].stamp == before[i].stamp);
        CHECK(after[i].p_W_B == before[i].p_W_B);
        CHECK(after[i].v_W_B == before[i].v_W_B);
        CHECK(after[i].accel_bias == before[i].accel_bias);
        const Eigen::Vector3d turn = so3_log(before[i].q_W_B.conjugate() * after[i].q_W_B);
        CHECK((turn - injector.turn_at(before[i].stamp)).norm() < 1e-8);
        CHECK((turn.norm() > 1e-5) == (i > 0));
    }
}

TEST_CASE("without turned images, or without a truth, none is written") {
    const test::TempDir dir;
    dir.write("truth.csv", "1000000000000,1,2,3,0.6,0.8,0,0\n");
    FaultInjector samples({parse_fault("vibration=flight")}, {}, {}, {kBegin});
    write_turned_truth(dir.file("truth.csv"), samples, dir.file("turned.csv"));
    FaultInjector images({parse_fault("vibration=flight,1,1,images")}, {}, {}, {kBegin});
    write_turned_truth(dir.file("none"), images, dir.file("turned.csv"));
    CHECK_FALSE(std::filesystem::exists(dir.file("turned.csv")));
    write_turned_truth(dir.file("truth.csv"), images, dir.file("turned.csv"));
    CHECK(states_of(dir.file("turned.csv")).size() == 1);
}

}  // namespace
}  // namespace facet::turned_truth_test
