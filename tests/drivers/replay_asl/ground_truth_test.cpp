// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/ground_truth.h"

#include <catch2/catch.hpp>

#include "tests/support/temp_dir.h"

namespace facet::ground_truth_test {
namespace {

TEST_CASE("ground truth of 17 columns has pose and motion, of 8 columns only the pose") {
    const test::TempDir dir;
    const std::string path = dir.write("mav0/state_groundtruth_estimate0/data.csv",
                                       "#timestamp\n"
                                       "1403636580838555648,1,2,3,0,1,0,0,4,5,6,7,8,9,10,11,12\n"
                                       "1403636580843555648,1,2,3,0.6,0,0.8,0\n");
    REQUIRE(find_ground_truth(dir.path()) == path);
    REQUIRE(find_ground_truth(dir.file("mav0")) == path);
    REQUIRE(find_ground_truth(path) == path);
    CHECK(find_ground_truth(dir.file("nowhere")).empty());
    std::vector<GroundTruthState> states;
    std::string error;
    REQUIRE(read_ground_truth(path, {}, states, error) == Status::kOk);
    REQUIRE(states.size() == 2);
    CHECK(states[0].stamp.ns == 1403636580838555648);
    CHECK(states[0].p_W_B == Eigen::Vector3d(1, 2, 3));
    CHECK(states[0].q_W_B.x() == 1.0);
    CHECK(states[0].has_motion);
    CHECK(states[0].v_W_B == Eigen::Vector3d(4, 5, 6));
    CHECK(states[0].gyro_bias == Eigen::Vector3d(7, 8, 9));
    CHECK(states[0].accel_bias == Eigen::Vector3d(10, 11, 12));
    CHECK_FALSE(states[1].has_motion);
    CHECK(states[1].q_W_B.w() == Approx(0.6));
    CHECK(states[1].q_W_B.y() == Approx(0.8));
}

TEST_CASE("bad ground-truth rows are skipped with file and line") {
    const test::TempDir dir;
    const std::string path = dir.write("data.csv",
                                       "#timestamp\r\n"
                                       "10,0,0,0,1,0,0,0\r\n"
                                       "20,0,0,0,1,0,0\r\n"
                                       "30,0,0,nan,1,0,0,0\r\n"
                                       "40,0,0,0,2,0,0,0\r\n"
                                       "10,0,0,0,1,0,0,0\r\n"
                                       "5,0,0,0,1,0,0,0\r\n"
                                       "x,0,0,0,1,0,0,0\r\n"
                                       "60,0,a,0,1,0,0,0\r\n"
                                       "50,0,0,0,1,0,0,0");
    std::vector<AslWarning> warnings;
    std::vector<GroundTruthState> states;
    std::string error;
    REQUIRE(read_ground_truth(
                path, [&](const AslWarning& w) { warnings.push_back(w); }, states, error) == Status::kOk);
    REQUIRE(states.size() == 2);
    CHECK(states[1].stamp.ns == 50);
    const std::vector<std::pair<std::int64_t, AslWarningKind>> expected{
        {3, AslWarningKind::kMalformedRow}, {4, AslWarningKind::kNotFinite},  {5, AslWarningKind::kMalformedRow},
        {6, AslWarningKind::kDuplicate},    {7, AslWarningKind::kOutOfOrder}, {8, AslWarningKind::kMalformedRow},
        {9, AslWarningKind::kMalformedRow}};
    REQUIRE(warnings.size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        CHECK(warnings[i].line == expected[i].first);
        CHECK(warnings[i].kind == expected[i].second);
        CHECK(warnings[i].text().starts_with(path + ":" + std::to_string(expected[i].first) + ": "));
    }
}

TEST_CASE("ground truth without a valid row is an error naming the path") {
    const test::TempDir dir;
    std::vector<GroundTruthState> states;
    std::string error;
    CHECK(read_ground_truth(dir.file("none.csv"), {}, states, error) == Status::kIo);
    CHECK(error == dir.file("none.csv") + ": cannot be read");
    const std::string empty = dir.write("empty.csv", "#nothing\n");
    CHECK(read_ground_truth(empty, {}, states, error) == Status::kIo);
    CHECK(error == empty + ": holds no valid row");
}

}  // namespace
}  // namespace facet::ground_truth_test
