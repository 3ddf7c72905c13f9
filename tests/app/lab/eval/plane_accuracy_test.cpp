// SPDX-License-Identifier: BSD-2-Clause
// Plane evaluation on a scene whose planes are known.
#include "app/lab/eval/plane_accuracy.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "app/support/input_error.h"
#include "tests/support/ideal_camera.h"

namespace facet::plane_accuracy_test {
namespace {

using Eigen::Vector3d;

void add_quad(TriangleSoup& soup, const Vector3d& corner, const Vector3d& a, const Vector3d& b) {
    const auto n = static_cast<int>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), {corner, corner + a, corner + a + b, corner + b});
    soup.triangles.push_back({n, n + 1, n + 2});
    soup.triangles.push_back({n, n + 2, n + 3});
}

/// A wall at x = 3 m, a small panel 1 m in front of its middle, a far wall hidden behind, and a slanted board; seen
/// from the origin for `seconds`.
SceneTruth scene(double seconds) {
    SceneTruth truth;
    add_quad(truth.surface, {3.0, -2.0, -2.0}, {0.0, 0.0, 4.0}, {0.0, 4.0, 0.0});
    add_quad(truth.surface, {2.0, -0.3, -0.3}, {0.0, 0.0, 0.6}, {0.0, 0.6, 0.0});
    add_quad(truth.surface, {4.0, -2.0, -2.0}, {0.0, 0.0, 4.0}, {0.0, 4.0, 0.0});
    add_quad(truth.surface, {2.0, 0.5, -0.5}, {0.5, 0.0, 1.0}, {0.0, 1.2, 0.0});
    const double s = std::sqrt(1.25);
    truth.planes = {{"wall", {-1.0, 0.0, 0.0}, -3.0},
                    {"panel", {-1.0, 0.0, 0.0}, -2.0},
                    {"hidden", {-1.0, 0.0, 0.0}, -4.0},
                    {"board", {-1.0 / s, 0.0, 0.5 / s}, -2.25 / s}};
    truth.camera = test::ideal_camera(800, 800, 450.0);
    truth.T_W_C0.assign(static_cast<std::size_t>(std::lround(seconds / 0.2)), test::looking_along_x());
    return truth;
}

/// Told at one keyframe: turned by this much about z, and off by this much.
PlaneRow row(std::uint32_t id, int second, double x, double turn_deg = 0.0) {
    PlaneRow r;
    r.stamp = {second * 1'000'000'000LL};
    r.id = id;
    const double a = turn_deg * std::numbers::pi / 180.0;
    r.normal = {-std::cos(a), std::sin(a), 0.0};
    r.centroid = {x, 1.0, 0.0};
    r.distance = r.normal.dot(r.centroid);
    r.landmarks = 50;
    r.area_m2 = 2.0;
    return r;
}

TEST_CASE("a wall found is found, with its errors; what is small, hidden or slanted is not asked for") {
    const PlaneEvaluation e = evaluate_planes({row(4, 1, 3.02, 0.5), row(4, 2, 3.01, 0.7)}, {}, scene(2.0), Se3{}, {});
    CHECK(e.wanted == 1);
    CHECK(e.wanted_found == 1);
    CHECK(e.recall() == 1.0);
    CHECK(e.precision() == 1.0);
    CHECK(e.told == 2);
    CHECK(e.told_right == 2);
    CHECK(e.good_angle == 1.0);
    CHECK(e.good_offset == 1.0);
    CHECK(e.p90_offset_m <= 0.02 + 1e-9);
    REQUIRE(e.found.size() == 1);
    CHECK(e.found[0].last.truth == 0);
    CHECK(e.found[0].last.angle_deg == Approx(0.7));
    CHECK(e.found[0].last.offset_m == Approx(0.01));
    REQUIRE(e.truths.size() == 4);
    CHECK(e.truths[0].ids == 1);
    CHECK(e.truths[0].keyframes == 2);
    CHECK(e.truths[0].seen_s == Approx(2.0));
    CHECK(e.truths[0].area_m2 > 10.0);
    CHECK(e.truths[0].area_m2 < 16.0);
    CHECK(e.truths[1].area_m2 == Approx(0.36).epsilon(0.2));
    CHECK_FALSE(e.truths[1].is_wanted);
    CHECK(e.truths[2].area_m2 == Approx(0.0).margin(0.2));
    CHECK(e.truths[3].seen_s == Approx(2.0));
    CHECK_FALSE(e.truths[3].is_wanted);
}

TEST_CASE("planes in the air, of the wrong side, turned or far from the surface are false") {
    PlaneRow back = row(3, 1, 3.0);
    back.normal = -back.normal;
    PlaneRow beside = row(5, 1, 3.0);
    beside.centroid = {3.0, 4.0, 0.0};
    const PlaneEvaluation e = evaluate_planes({row(1, 1, 3.2), row(2, 1, 3.0, 8.0), back, row(4, 1, 3.0, 2.0), beside},
                                              {}, scene(2.0), Se3{}, {});
    CHECK(e.found.size() == 5);
    CHECK(e.right == 1);
    CHECK(e.precision() == Approx(0.2));
    CHECK(e.told_right == 1);
    CHECK(e.good_angle == 0.0);
    CHECK(e.good_offset == 1.0);
}

TEST_CASE("a wall seen too briefly is not asked for; one missed lowers recall; alignment is applied") {
    CHECK(evaluate_planes({}, {}, scene(1.8), Se3{}, {}).wanted == 0);
    const PlaneEvaluation missed = evaluate_planes({}, {}, scene(2.0), Se3{}, {});
    CHECK(missed.recall() == 0.0);
    CHECK(missed.precision() == 0.0);
    const Se3 T{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d::UnitZ())), {1.0, 2.0, 0.5}};
    PlaneRow r = row(0, 1, 3.0);
    r.centroid = T.inverse() * r.centroid;
    r.normal = T.q.conjugate() * r.normal;
    r.distance = r.normal.dot(r.centroid);
    const PlaneEvaluation e = evaluate_planes({r}, {}, scene(2.0), T, {});
    CHECK(e.wanted_found == 1);
    CHECK(e.found[0].last.offset_m == Approx(0.0).margin(1e-9));
}

TEST_CASE(
    "judged strictly, a wall counts once, at its own place, within 2 degrees and 3 cm; boards of any tilt count") {
    const auto strict = [](const std::vector<PlaneRow>& rows) {
        return evaluate_planes(rows, {}, scene(2.0), Se3{}, {}).strict;
    };
    const StrictPlanes one = strict({row(1, 1, 3.02, 1.5), row(1, 2, 2.99)});
    CHECK(one.found == 1);
    CHECK(one.right == 1);
    CHECK(one.wanted == 2);  // wall and board; the panel has 0.36 m^2
    CHECK(one.wanted_found == 1);
    CHECK(one.recall() == 0.5);
    CHECK(one.area_recall() > 0.85);
    CHECK(one.area_recall() < 0.98);
    CHECK(strict({row(1, 1, 3.0), row(2, 2, 3.0)}).precision() == 0.5);
    CHECK(strict({row(1, 1, 3.04)}).right == 0);
    CHECK(strict({row(1, 1, 3.0, 2.5)}).right == 0);
    CHECK(strict({row(1, 1, 3.0), row(1, 2, 3.1)}).right == 0);  // at half of its keyframes only
    PlaneRow border = row(1, 1, 3.0);
    border.centroid.y() = 2.3;  // beyond the wall's end, with less than half of its area on it
    CHECK(strict({border}).right == 0);
    PlaneRow board = row(1, 1, 2.25);
    board.normal = Vector3d(-1.0, 0.0, 0.5).normalized();
    board.centroid = {2.25, 1.1, 0.0};
    board.area_m2 = 1.0;
    CHECK(strict({board}).wanted_found == 1);
}

TEST_CASE("planes.csv is read by its columns' names, and a broken row is named") {
    const std::string path = (std::filesystem::temp_directory_path() / "facet_planes_test.csv").string();
    std::ofstream(path) << "stamp_ns,id,kind,nx,ny,nz,distance_m,landmarks,area_m2,cx,cy,cz\n"
                           "1000,7,vertical,-1,0,0,-3,42,1.5,3,0.5,1\n";
    const auto rows = read_planes(path);
    REQUIRE(rows.size() == 1);
    CHECK(rows[0].stamp.ns == 1000);
    CHECK(rows[0].id == 7);
    CHECK(rows[0].normal.x() == -1.0);
    CHECK(rows[0].distance == -3.0);
    CHECK(rows[0].landmarks == 42.0);
    CHECK(rows[0].area_m2 == 1.5);
    CHECK(rows[0].centroid.y() == 0.5);
    std::ofstream(path, std::ios::app) << "2000,7,vertical,-1,0,0,nan,42,1.5,3,0.5,1\n";
    CHECK_THROWS_AS(read_planes(path), InputError);
    std::ofstream(path) << "stamp_ns,id\n";
    CHECK_THROWS_AS(read_planes(path), InputError);
    std::remove(path.c_str());
    CHECK_THROWS_AS(read_planes(path), InputError);
}

}  // namespace
}  // namespace facet::plane_accuracy_test
