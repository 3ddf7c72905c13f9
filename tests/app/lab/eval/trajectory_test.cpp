// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/trajectory.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::trajectory_test {
namespace {

TEST_CASE("TUM stamps are read to the nanosecond") {
    const test::TempDir dir;
    const Trajectory t = read_tum(dir.write("a.tum",
                                            "# seconds x y z qx qy qz qw\r\n"
                                            "1403636580.838555648 1 2 3 0 0 0 1\r\n"
                                            "\n"
                                            "1403636580.838555649\t-1e-3 2 3 0.6 0 0 0.8\n"
                                            "1403636581 1 2 3 0 0 0 -1\n"
                                            "1403636581.25 1 2 3 0 0 0 1"));
    REQUIRE(t.size() == 4);
    CHECK(t[0].stamp.ns == 1403636580838555648);
    CHECK(t[1].stamp.ns == 1403636580838555649);
    CHECK(t[2].stamp.ns == 1403636581000000000);
    CHECK(t[3].stamp.ns == 1403636581250000000);
    CHECK(t[1].T_W_B.p == Eigen::Vector3d(-1e-3, 2, 3));
    CHECK(t[1].T_W_B.q.x() == Approx(0.6));
    CHECK(read_tum(dir.write("empty.tum", "")).empty());
}

TEST_CASE("TUM stamps with an exponent are as exact") {
    const struct {
        const char* text;
        std::int64_t ns;
    } stamps[] = {{"1.403636580838555648e+09", 1403636580838555648},
                  {"1.403636580838555648E9", 1403636580838555648},
                  {"1403636580838.555648e-3", 1403636580838555648},
                  {"14.5e-1", 1450000000},
                  {"2e0", 2000000000},
                  {"2e-12", 0},
                  {"1e5", 100000000000000},
                  {"-1.5e1", -15000000000},
                  {"0e5", 0},
                  {"000.25", 250000000}};
    for (const auto& stamp : stamps) {
        INFO(stamp.text);
        const test::TempDir dir;
        const Trajectory t = read_tum(dir.write("a.tum", std::string(stamp.text) + " 1 2 3 0 0 0 1\n"));
        REQUIRE(t.size() == 1);
        CHECK(t[0].stamp.ns == stamp.ns);
    }
}

TEST_CASE("a last row that was cut off is left out") {
    const test::TempDir dir;
    CHECK(read_tum(dir.write("a.tum", "1 1 2 3 0 0 0 1\n2 1 2 3 0 0")).size() == 1);
    CHECK(read_tum(dir.write("a.tum", "1 1 2 3 0 0 0 1\n2 1 2 3 0 0 0 1")).size() == 2);
    CHECK_FALSE(test::input_error_text([&] { read_tum(dir.write("a.tum", "1 1 2\n2 1 2 3 0 0 0 1\n")); }).empty());
}

TEST_CASE("bad TUM rows are errors with file and line") {
    struct Bad {
        const char* row;
        const char* complaint;
    };
    const Bad bad =
        GENERATE(Bad{"2 1 2 3 0 0 0", "row has 7 columns, not 8 (seconds x y z qx qy qz qw)"},
                 Bad{"2 1 2 x 0 0 0 1", "column 4 is not a finite number"},
                 Bad{"2 1 2 nan 0 0 0 1", "column 4 is not a finite number"},
                 Bad{"2 1 2 3 0 0 0 0.5", "quaternion is not of unit length"},
                 Bad{"1e11 1 2 3 0 0 0 1", "stamp is out of range"}, Bad{"1 1 2 3 0 0 0 1", "stamp does not increase"});
    const test::TempDir dir;
    const std::string path = dir.write("a.tum", std::string("# t\n1 0 0 0 0 0 0 1\n") + bad.row + "\n");
    CHECK(test::input_error_text([&] { read_tum(path); }) == path + ":3: " + bad.complaint);
    CHECK(test::input_error_text([&] { read_tum(dir.file("no.tum")); }) == dir.file("no.tum") + ": cannot be read");
}

StampedPose pose(double t_s, double x, double yaw) {
    return {{static_cast<std::int64_t>(t_s * 1e9)},
            {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), {x, 0, 0}}};
}

TEST_CASE("the ground truth is interpolated at the estimate's stamps") {
    const Trajectory truth{pose(1.0, 0.0, 0.0), pose(1.1, 1.0, 0.4), pose(3.0, 5.0, 0.0), pose(3.1, 6.0, 0.0)};
    const Trajectory estimate{pose(0.9, 0, 0), pose(1.0, 0, 0), pose(1.025, 0, 0),
                              pose(2.0, 0, 0), pose(3.1, 0, 0), pose(3.15, 0, 0)};
    const std::vector<PosePair> pairs = associate(truth, estimate, Duration::from_seconds(0.5));
    REQUIRE(pairs.size() == 3);  // before, within a hole of 1.9 s, and after the ground truth: left out
    CHECK(pairs[0].truth.p.x() == 0.0);
    CHECK(pairs[1].truth.p.x() == Approx(0.25));
    CHECK(so3_log(pairs[1].truth.q).z() == Approx(0.1));
    CHECK(pairs[2].truth.p.x() == 6.0);
}

}  // namespace
}  // namespace facet::trajectory_test
