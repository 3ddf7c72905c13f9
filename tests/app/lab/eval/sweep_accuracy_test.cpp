// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/sweep_accuracy.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/support/input_error.h"
#include "tests/support/temp_dir.h"

namespace facet::sweep_accuracy_test {
namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Walls of 40 m and 4 m height at x = 3 and at y = 4.
TriangleSoup two_walls() {
    TriangleSoup soup;
    soup.vertices = {{3, -20, -2}, {3, 20, -2}, {3, 20, 2}, {3, -20, 2},
                     {-20, 4, -2}, {20, 4, -2}, {20, 4, 2}, {-20, 4, 2}};
    soup.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    return soup;
}

TEST_CASE("sectors are missed, false, unknown or right, in the true world at their stamp") {
    // The estimate's world is turned by 90 degrees: it looks along its -y axis, which is the true x axis.
    const Se3 estimate{Eigen::Quaterniond(Eigen::AngleAxisd(-0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ())),
                       {5.0, 6.0, 7.0}};
    const std::vector<PosePair> pairs{{{1'000}, Se3{}, estimate}};
    SweepRow sweep;
    sweep.stamp = {1'000};
    sweep.p_W = estimate.p;
    sweep.ahead_rad = -0.5 * std::numbers::pi;
    sweep.below_m = sweep.above_m = 0.5;
    sweep.range_m.fill(kUnknown);
    sweep.range_m[0] = 3.1;                      // the wall ahead at 3 m
    sweep.range_m[1] = 2.0;                      // a false obstacle
    sweep.range_m[2] = kFree;                    // missed
    sweep.range_m[kSweepRowSectors - 18] = 4.1;  // the wall on the left at 4 m
    sweep.range_m[36] = kFree;                   // behind there is nothing
    sweep.range_m[37] = 4.5;                     // false
    SweepRow without = sweep;
    without.stamp = {5'000'000'000};
    const TriangleSoup walls = two_walls();
    const ObstacleTruth truth(walls, std::nullopt);
    const SweepEvaluation e = evaluate_sweeps({sweep, without}, pairs, truth, {});
    CHECK(e.without_truth == 1);
    CHECK(e.sectors == 72);
    CHECK(e.unknown == 66);
    CHECK(e.missed == 1);
    CHECK(e.false_obstacle == 2);
    CHECK(e.hits == 3);
    CHECK(e.median_error_m == Approx(0.1).margin(0.01));
    CHECK(e.p90_error_m < 0.11);
    CHECK(nlohmann::json::parse(json_report(e))["missed"].get<double>() == Approx(1.0 / 72.0));
    CHECK(text_report(e).find("missed 1.39 %") != std::string::npos);
    // What is above the band does not count.
    SweepRow higher = sweep;
    higher.p_W.z() += 3.0;
    CHECK(evaluate_sweeps({higher}, pairs, truth, {}).missed == 0);
}

TEST_CASE("sweeps.csv is read, and a wrong row is named") {
    const test::TempDir folder;
    const std::string path = folder.path() + "/sweeps.csv";
    const auto write = [&](const std::string& last) {
        std::ofstream file(path);
        file << "stamp_ns,px,py,pz,ahead_rad,below_m,above_m,r0_m\n9,1,2,3,0.5,0.25,0.75";
        for (std::size_t k = 0; k + 2 < kSweepRowSectors; ++k) {
            file << "," << k;
        }
        file << ",inf," << last << "\n";
    };
    write("nan");
    const std::vector<SweepRow> sweeps = read_sweeps(path);
    REQUIRE(sweeps.size() == 1);
    CHECK(sweeps[0].stamp.ns == 9);
    CHECK(sweeps[0].p_W == Eigen::Vector3d(1.0, 2.0, 3.0));
    CHECK(sweeps[0].ahead_rad == 0.5);
    CHECK(sweeps[0].below_m == 0.25);
    CHECK(sweeps[0].above_m == 0.75);
    CHECK(sweeps[0].range_m[69] == 69.0);
    CHECK(sweeps[0].range_m[70] == kFree);
    CHECK(std::isnan(sweeps[0].range_m[71]));
    write("-1");
    CHECK_THROWS_AS(read_sweeps(path), InputError);
    write("1,2");
    CHECK_THROWS_AS(read_sweeps(path), InputError);
    CHECK_THROWS_AS(read_sweeps(folder.path() + "/none.csv"), InputError);
}

}  // namespace
}  // namespace facet::sweep_accuracy_test
