// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/obstacle_accuracy.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/support/input_error.h"
#include "tests/support/temp_dir.h"

namespace facet::obstacle_accuracy_test {
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
    return {{1'000}, {0.0, 0.0, 1.0}, direction, true, is_unknown, free_m, obstacle_m, 0.9, 2.0};
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
    // Along the wall at 10 cm: the cell that ends it is near a true surface.
    rays.push_back(ray(east, false, 2.0, 2.0));
    rays.back().p_W = {-1.0, 2.9, 1.0};
    rays.back().direction = Vector3d::UnitX();
    const TriangleSoup wall = wall_east();
    const ObstacleEvaluation e = evaluate_obstacles(rays, pairs, ObstacleTruth(wall, std::nullopt), {});
    CHECK(e.without_truth == 1);
    CHECK(e.all.rays == 10);
    CHECK(e.all.missed == 1);
    CHECK(e.all.false_obstacle == 3);
    CHECK(e.all.phantom == 2);
    CHECK(e.phantom_age_s == 2.0);
    CHECK(e.all.unknown == 2);
    CHECK(e.in_view.rays == 9);
    CHECK(e.in_view.false_obstacle == 2);
    CHECK(e.hits == 2);
    CHECK(e.median_error_m == Approx(0.125));
    const auto json = nlohmann::json::parse(json_report(e));
    CHECK(json["all"]["missed"].get<double>() == Approx(0.1));
    CHECK(text_report(e).find("in view") != std::string::npos);
}

TEST_CASE("a mover is an obstacle where it is, and none where it was") {
    const MoverTruth mover(1.0, {{{1'000'000'000}, {2'000'000'000}, {2.0, 0.0, 0.0}, {0.0, 3.0, 0.0}, 0.0, 0.0}});
    const TriangleSoup wall = wall_east();
    const ObstacleTruth truth(wall, mover);
    const Vector3d east = Vector3d::UnitX();
    CHECK(truth.cast(Vector3d::Zero(), east, 5.0, {900'000'000}) == Approx(3.0));
    CHECK(truth.cast(Vector3d::Zero(), east, 5.0, {1'000'000'000}) == Approx(1.5));
    CHECK(truth.cast(Vector3d::Zero(), east, 5.0, {1'500'000'000}) == Approx(3.0));
    CHECK(truth.cast({0.0, 1.5, 0.0}, east, 5.0, {1'500'000'000}) == Approx(1.5));
    CHECK(truth.distance({1.0, 0.0, 0.0}, 5.0, {1'000'000'000}) == Approx(0.5));
    CHECK(truth.distance({1.0, 0.0, 0.0}, 5.0, {2'000'000'001}) == Approx(2.0));
    // A cube of a metre has six square metres.
    const double more = static_cast<double>(truth.samples({1'000'000'000}).size() - truth.samples({0}).size());
    CHECK(more == Approx(6.0 * ObstacleTruth::kSamples_per_m2).margin(6.0));
}

TEST_CASE("mover.json is read, may be missing, and is named if damaged") {
    const test::TempDir folder;
    const std::string path = folder.path() + "/mover.json";
    CHECK_FALSE(MoverTruth::load(path).has_value());
    std::ofstream(path) << R"({"epoch_ns": 5000000000, "side_m": 0.75, "crossings": [{"begin_s": 1.0, "end_s": 3.0,
        "start_m": [1, 2, 3], "velocity_m_per_s": [1, 0, 0], "start_yaw_rad": 0.5, "yaw_rate_rad_per_s": 0.1}]})";
    const std::optional<MoverTruth> mover = MoverTruth::load(path);
    REQUIRE(mover.has_value());
    CHECK(mover->side_m() == 0.75);
    CHECK_FALSE(mover->pose({5'900'000'000}).has_value());
    const std::optional<Se3> pose = mover->pose({7'000'000'000});
    REQUIRE(pose.has_value());
    CHECK((pose->p - Vector3d(2.0, 2.0, 3.0)).norm() < 1e-12);
    CHECK((pose->q * Vector3d::UnitX() - Vector3d(std::cos(0.6), std::sin(0.6), 0.0)).norm() < 1e-12);
    std::ofstream(path) << "{\"side_m\": 0.75}";
    CHECK_THROWS_AS(MoverTruth::load(path), InputError);
}

TEST_CASE("rays.csv is read, and a wrong row is named") {
    const test::TempDir folder;
    const std::string path = folder.path() + "/rays.csv";
    const std::string head = "stamp_ns,px,py,pz,dx,dy,dz,in_view,unknown,free_m,obstacle_m,certainty,age_s\n";
    std::ofstream(path) << head << "5,1,2,3,0,1,0,1,0,2.5,inf,0.75,1.5\n";
    const std::vector<RayRow> rays = read_rays(path);
    REQUIRE(rays.size() == 1);
    CHECK(rays[0].stamp.ns == 5);
    CHECK(rays[0].p_W == Vector3d(1.0, 2.0, 3.0));
    CHECK(rays[0].direction == Vector3d::UnitY());
    CHECK(rays[0].is_in_view);
    CHECK_FALSE(rays[0].is_unknown);
    CHECK(rays[0].free_m == 2.5);
    CHECK(rays[0].obstacle_m == kNone);
    CHECK(rays[0].certainty == 0.75);
    CHECK(rays[0].age_s == 1.5);
    std::ofstream(path) << head << "5,1,2,3,0,1,0,1,0,nan,inf,0.75,1.5\n";
    CHECK_THROWS_AS(read_rays(path), InputError);
    CHECK_THROWS_AS(read_rays(folder.path() + "/none.csv"), InputError);
}

}  // namespace
}  // namespace facet::obstacle_accuracy_test
