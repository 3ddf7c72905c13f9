// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/obstacle_accuracy.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/support/input_error.h"
#include "tests/support/temp_dir.h"

namespace facet {
namespace {

using Eigen::Vector3d;

constexpr double kNone = std::numeric_limits<double>::infinity();

/// A square of 20 m, 3 m east of the true origin.
TriangleSoup wall_east() {
    TriangleSoup soup;
    soup.vertices = {{3, -10, -10}, {3, 10, -10}, {3, 10, 10}, {3, -10, 10}};
    soup.triangles = {{0, 1, 2}, {0, 2, 3}};
    return soup;
}

RayRow ray(const Vector3d& direction, bool is_unknown, double free_m, double obstacle_m) {
    return {{1'000}, {0.0, 0.0, 1.0}, direction, true, is_unknown, free_m, obstacle_m};
}

TEST_CASE("rays are missed, false, unknown or right, in the true world at their stamp") {
    // The estimate is turned by 90 degrees and 1 m too high: what it calls north is east.
    const Se3 estimate{Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitZ())),
                       {0.0, 0.0, 1.0}};
    const std::vector<PosePair> pairs{{{1'000}, Se3{}, estimate}};
    const Vector3d east = Vector3d::UnitY();
    std::vector<RayRow> rays{
        ray(east, false, 2.9, 2.9),    // right
        ray(east, false, 5.5, kNone),  // through the wall
        ray(east, false, 3.15, 3.15),  // within tolerance
        ray(east, false, 2.0, 2.0),    // too early
        ray(east, true, 2.0, 2.95),    // unknown before it
        ray(east, true, 2.9, kNone),   // unknown where the wall begins: right
        ray(-east, false, 5.5, kNone), ray(-east, true, 4.0, kNone), ray(-east, false, 4.0, 4.0),
    };
    rays.back().is_in_view = false;
    rays.push_back(rays.front());
    rays.back().stamp = {500'000'000};
    const ObstacleEvaluation e = evaluate_obstacles(rays, pairs, wall_east(), {});
    CHECK(e.without_truth == 1);
    CHECK(e.all.rays == 9);
    CHECK(e.all.missed == 1);
    CHECK(e.all.false_obstacle == 2);
    CHECK(e.all.unknown == 2);
    CHECK(e.in_view.rays == 8);
    CHECK(e.in_view.false_obstacle == 1);
    CHECK(e.hits == 2);
    CHECK(e.median_error_m == Approx(0.125));
    const auto json = nlohmann::json::parse(json_report(e));
    CHECK(json["all"]["missed"].get<double>() == Approx(1.0 / 9.0));
    CHECK(text_report(e).find("in view") != std::string::npos);
}

TEST_CASE("rays.csv is read, and a wrong row is named") {
    const test::TempDir folder;
    const std::string path = folder.path() + "/rays.csv";
    const std::string head = "stamp_ns,px,py,pz,dx,dy,dz,in_view,unknown,free_m,obstacle_m\n";
    std::ofstream(path) << head << "5,1,2,3,0,1,0,1,0,2.5,inf\n";
    const std::vector<RayRow> rays = read_rays(path);
    REQUIRE(rays.size() == 1);
    CHECK(rays[0].stamp.ns == 5);
    CHECK(rays[0].p_W == Vector3d(1.0, 2.0, 3.0));
    CHECK(rays[0].direction == Vector3d::UnitY());
    CHECK(rays[0].is_in_view);
    CHECK_FALSE(rays[0].is_unknown);
    CHECK(rays[0].free_m == 2.5);
    CHECK(rays[0].obstacle_m == kNone);
    std::ofstream(path) << head << "5,1,2,3,0,1,0,1,0,nan,inf\n";
    CHECK_THROWS_AS(read_rays(path), InputError);
    CHECK_THROWS_AS(read_rays(folder.path() + "/none.csv"), InputError);
}

}  // namespace
}  // namespace facet
