// SPDX-License-Identifier: BSD-2-Clause
// Planes judged strictly, with the regions that a run tells of them.
#include "app/lab/eval/strict_planes.h"

#include <catch2/catch.hpp>

#include "app/support/input_error.h"
#include "tests/support/temp_dir.h"

namespace facet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A wall at x = 3 m on both sides of a door, 2 m each and 1.4 m apart, as two planes of the scene.
SceneTruth wall_with_door() {
    SceneTruth truth;
    for (const double y : {-2.7, 0.7}) {
        const auto n = static_cast<int>(truth.surface.vertices.size());
        truth.surface.vertices.insert(truth.surface.vertices.end(),
                                      {{3.0, y, 0.0}, {3.0, y, 2.0}, {3.0, y + 2.0, 2.0}, {3.0, y + 2.0, 0.0}});
        truth.surface.triangles.push_back({n, n + 1, n + 2});
        truth.surface.triangles.push_back({n, n + 2, n + 3});
        EvalPlane plane{y < 0.0 ? "left" : "right", {-1.0, 0.0, 0.0}, -3.0};
        plane.box = {Vector3d(3.0, y, 0.0), Vector3d(3.0, y + 2.0, 2.0)};
        truth.planes.push_back(plane);
    }
    return truth;
}

/// Its landmarks are at the jambs, so that their centroid is in the door.
PlaneRow row(std::uint32_t id, double x = 3.0) {
    PlaneRow r;
    r.id = id;
    r.normal = {-1.0, 0.0, 0.0};
    r.distance = -x;
    r.centroid = {x, 0.0, 1.0};
    r.area_m2 = 1.5;
    return r;
}

/// Rectangles of the plane x = 3 m.
PlaneSurface rectangles(std::initializer_list<Eigen::AlignedBox2d> boxes) {
    PlaneOutline outline{{3.0, 0.0, 0.0}, {Vector3d::UnitY(), Vector3d::UnitZ()}, {}};
    for (const Eigen::AlignedBox2d& box : boxes) {
        outline.lines.push_back({box.corner(box.BottomLeft), box.corner(box.BottomRight), box.corner(box.TopRight),
                                 box.corner(box.TopLeft)});
    }
    return {{-1.0, 0.0, 0.0}, fill(outline)};
}

const Eigen::AlignedBox2d kLeft(Vector2d(-1.4, 0.2), Vector2d(-0.7, 1.8));
const Eigen::AlignedBox2d kRight(Vector2d(0.7, 0.2), Vector2d(1.2, 1.8));
const Eigen::AlignedBox2d kDoor(Vector2d(-0.7, 0.2), Vector2d(0.7, 1.8));

StrictPlanes judge(const std::vector<PlaneRow>& rows, const PlaneSurfaces& surfaces) {
    const SceneTruth truth = wall_with_door();
    return judge_strictly(rows, surfaces, truth, TriangleTree(truth.surface), Se3{}, {4.0, 4.0});
}

TEST_CASE("a wall on both sides of a door is where its regions are, not about the centroid of its landmarks") {
    const StrictPlanes both = judge({row(1)}, {{1, rectangles({kLeft, kRight})}});
    CHECK(both.right == 1);
    CHECK(both.wanted == 2);
    CHECK(both.wanted_found == 1);  // the left half, which has more of it
    CHECK(both.area_recall() == 0.5);
    CHECK(judge({row(1)}, {}).right == 0);                          // a disc in the door
    CHECK(judge({row(1)}, {{2, rectangles({kLeft})}}).right == 0);  // the regions of another plane
}

TEST_CASE("a plane over an opening, or off its surface, is wrong however right its regions' place is") {
    CHECK(judge({row(1)}, {{1, rectangles({kLeft, kDoor})}}).right == 0);  // a third of it is wall
    CHECK(judge({row(1)}, {{1, rectangles({kLeft, kRight, {Vector2d(-0.7, 0.2), Vector2d(0.0, 1.8)}})}}).right == 1);
    CHECK(judge({row(1, 3.04)}, {{1, rectangles({kLeft, kRight})}}).right == 0);
    CHECK(judge({row(1)}, {{1, PlaneSurface{{-1.0, 0.0, 0.0}, {}}}}).right == 0);
    CHECK(judge({row(1), row(2)}, {{1, rectangles({kLeft})}, {2, rectangles({kRight})}}).right == 2);
    CHECK(judge({row(1), row(2)}, {{1, rectangles({kLeft})}, {2, rectangles({kLeft})}}).right == 1);
}

TEST_CASE("regions are filled up to their boundary, without their holes") {
    const test::TempDir folder;
    folder.write("planes.json", R"([{"id": 3, "normal": [0, 0, 1], "distance": 1, "origin": [10, 0, 1],
        "axes": [[1, 0, 0], [0, 1, 0]], "regions": [
            {"area": 3.0, "boundary": [[0, 0], [2, 0], [2, 2], [0, 2]], "holes": [[[0.5, 0.5], [0.5, 1.5], [1.5, 1.5], [1.5, 0.5]]]},
            {"area": 0.5, "boundary": [[3, 0], [4, 0], [4, 1]], "holes": []}]},
        {"id": 4, "normal": [0, 0, 1], "distance": 1}])");
    const PlaneSurfaces surfaces = load_surfaces(folder.file("planes.json"));
    REQUIRE(surfaces.size() == 1);
    const PlaneSurface& surface = surfaces.at(3);
    CHECK(surface.normal == Vector3d::UnitZ());
    CHECK(static_cast<double>(surface.squares.size()) * kSurfaceSquare_m * kSurfaceSquare_m ==
          Approx(3.5).epsilon(0.02));
    for (const Vector3d& square : surface.squares) {
        const Vector2d at(square.x() - 10.0, square.y());
        const bool is_in_ring = at.x() < 2.0 && at.y() < 2.0 && (at.array() - 1.0).abs().maxCoeff() > 0.5;
        const bool is_in_triangle = at.x() > 3.0 && at.x() < 4.0 && at.y() < at.x() - 3.0 + 1e-9;
        CHECK((is_in_ring || is_in_triangle));
        CHECK(square.z() == 1.0);
    }
}

TEST_CASE("regions that cannot be used are refused; a run without planes.json has none") {
    const test::TempDir folder;
    CHECK(load_surfaces(folder.file("planes.json")).empty());
    const auto load_with = [&](const std::string& axes, const std::string& regions) {
        folder.write("planes.json", R"([{"id": 3, "normal": [0, 0, 1], "distance": 1, "origin": [0, 0, 1], "axes": )" +
                                        axes + R"(, "regions": )" + regions + "}]");
        return load_surfaces(folder.file("planes.json"));
    };
    const std::string axes = "[[1, 0, 0], [0, 1, 0]]";
    CHECK(load_with(axes, "[]").empty());
    CHECK(load_with(axes, R"([{"boundary": [], "holes": []}])").at(3).squares.empty());
    CHECK_THROWS_AS(load_with("[[1, 0, 0]]", "[]"), InputError);
    CHECK_THROWS_AS(load_with(axes, "7"), InputError);
    CHECK_THROWS_AS(load_with(axes, "[7]"), InputError);
    CHECK_THROWS_AS(load_with(axes, R"([{"boundary": [[0, 0], [1, 0]]}])"), InputError);
    CHECK_THROWS_AS(load_with(axes, R"([{"boundary": [[0, 0, 0]], "holes": []}])"), InputError);
    CHECK_THROWS_AS(load_with(axes, R"([{"boundary": [[0, 1e300]], "holes": []}])"), InputError);
    CHECK_THROWS_AS(load_with(axes, R"([{"boundary": [[0, 0], [1e6, 0], [0, 1]], "holes": []}])"), InputError);
    CHECK_THROWS_AS(load_surfaces(folder.path()), InputError);
}

}  // namespace
}  // namespace facet
